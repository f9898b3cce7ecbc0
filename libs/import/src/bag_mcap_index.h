#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bag_bytes.h"
#include "bag_file.h"
#include "bag_mcap_summary.h"
#include "bag_unpack.h"

namespace talus::import
{
/** Records in a row: a chunk, or some that are in none. */
struct McapChunk
{
  std::uint64_t begin = 0, packed_bytes = 0;  //!< in the file
  std::uint64_t bytes = 0;  //!< of the records
  std::uint64_t start_ns = 0;  //!< the first log_time in it
  std::uint32_t crc = 0;  //!< of the records; 0: not known
  BagPacking packing = BagPacking::None;
  bool is_cut = false;  //!< the file ends in it
  bool is_known = false;  //!< was looked into: start_ns and channels are those of its messages
  std::vector<std::uint16_t> channels;
};

/** What is where in an MCAP file; found by going from record to record, which takes no payload into
 * memory, with or without a summary at the end. What a message is, its own record says: an index
 * and a summary are held against them. */
class McapIndex
{
 public:
  /** Throws std::runtime_error that names the file and the byte. `partial`: takes what is before
   * the place at which the file is cut, and leaves out chunks that are damaged. */
  McapIndex(const std::string& path, FileBytes& file, bool partial);

  const std::vector<BagTopic>& topics() const { return topics_; }
  std::vector<McapChunk>& chunks() { return chunks_; }

  /** Messages in chunks that were looked into, and in none, one number a topic. */
  std::vector<std::uint64_t> counts() const;

  /** Throws for one that no record declares. */
  std::size_t topic_of(std::uint16_t channel) const;

  /** The records of a chunk, unpacked, checked against their checksum; none of one that is left
   * out. */
  void read_chunk(McapChunk& chunk, std::vector<char>& records);

  std::vector<std::string> remarks() const;

 private:
  void walk();
  std::uint64_t walk_record(std::uint64_t at);
  void take_cut_chunk(std::uint64_t at);
  void add_record(McapRecord op, std::uint64_t begin, std::uint64_t bytes);
  void add_chunk(std::uint64_t begin, std::uint64_t bytes);
  void add_message(std::uint64_t begin, std::uint64_t bytes);
  void declare(McapRecord op, RecordReader record);
  void take_name(std::string_view name);
  void add_schema(RecordReader record);
  void add_channel(RecordReader record);
  void check_whole();
  bool tells_topics() const;
  void look_into_all();
  void unpack(const McapChunk& chunk, std::vector<char>& records);
  void learn(McapChunk& chunk, std::string_view records);
  void check_counts();
  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const;

  std::string path_;
  FileBytes& file_;
  bool partial_ = false;
  std::vector<BagTopic> topics_;
  std::size_t name_bytes_ = 0;  //!< of all topics
  std::vector<McapChunk> chunks_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::size_t> channels_;  //!< places in topics_
  std::vector<char> packed_;
  McapSummary summary_;
  std::map<std::uint16_t, std::uint64_t> counts_;  //!< messages found, by channel
  std::size_t unknown_ = 0;  //!< chunks that were not looked into
  bool is_loose_ = false;  //!< the last of chunks_ may take further messages
  bool is_open_ = false;  //!< topics_ are complete
  std::string cut_;  //!< where the file is cut, and why; else empty
  std::vector<std::string> left_out_;  //!< chunks that are damaged
};

/** Calls `take(op, content, begin of the content)` for each record. Throws std::runtime_error, with
 * what is wrong only, where one is cut short. */
template <class Take>
void for_each_record(std::string_view records, Take&& take)
{
  RecordReader reader(records);
  while (reader.left() > 0)
  {
    const auto op = static_cast<McapRecord>(reader.u8());
    const auto bytes = reader.u64();
    const std::size_t begin = records.size() - reader.left();
    take(op, reader.take(bytes), begin);
  }
}

}  // namespace talus::import
