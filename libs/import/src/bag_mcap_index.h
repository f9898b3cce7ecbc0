#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bag_bytes.h"
#include "bag_file.h"
#include "bag_unpack.h"

namespace talus::import
{
/** Opcodes of the records of MCAP, https://mcap.dev/spec. */
enum class McapRecord : std::uint8_t
{
  None = 0x00,
  Footer = 0x02,
  Schema = 0x03,
  Channel = 0x04,
  Message = 0x05,
  Chunk = 0x06,
  Statistics = 0x0B,
  DataEnd = 0x0F
};

/** Records in a row: a chunk, or some that are in none. */
struct McapChunk
{
  std::uint64_t begin = 0, packed_bytes = 0;  //!< in the file
  std::uint64_t bytes = 0;  //!< of the records
  std::uint64_t start_ns = 0;  //!< the first log_time in it, which only orders
  std::uint32_t crc = 0;  //!< of the records; 0: not known
  BagPacking packing = BagPacking::None;
  bool is_loose = false;  //!< messages that are in none
  bool is_cut = false;  //!< the file ends in it
  bool is_known = false;  //!< was read: these are the channels of its messages
  std::vector<std::uint16_t> channels;
};

/** What the end of a file states of the rest. */
struct McapStatistics
{
  std::uint64_t messages = 0;
  std::uint32_t chunks = 0;
  std::map<std::uint16_t, std::uint64_t> of_channel;  //!< messages; empty: not stated
};

/** What is where in an MCAP file; found by going from record to record, which takes no payload into
 * memory, with or without a summary at the end. What a message is, its own record says. */
class McapIndex
{
 public:
  /** Throws std::runtime_error that names the file and the byte. `partial`: takes what is before
   * the place at which the file is cut. */
  McapIndex(const std::string& path, FileBytes& file, bool partial);

  const std::vector<BagTopic>& topics() const { return topics_; }
  std::vector<McapChunk>& chunks() { return chunks_; }
  const std::vector<McapChunk>& chunks() const { return chunks_; }
  /** Where the file is cut, and why; else empty. */
  const std::string& cut() const { return cut_; }
  /** None of a file that is cut. */
  const std::optional<McapStatistics>& statistics() const { return statistics_; }
  /** Whether all channels that have messages are declared outside of the chunks. */
  bool has_all_topics() const;
  /** From now on no topic may be new. */
  void close_topics() { are_closed_ = true; }

  /** A schema or a channel; others are nothing to it. */
  void declare(McapRecord op, RecordReader record);
  /** Throws for one that no record declares. */
  std::size_t topic_of(std::uint16_t channel) const;

  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const;
  /** At the footer. `partial`: the file is cut there. */
  void fail_at_end(const std::string& what);

 private:
  void walk();
  std::uint64_t walk_record(std::uint64_t at);
  void take_cut_chunk(std::uint64_t at);
  void add_record(McapRecord op, std::uint64_t begin, std::uint64_t bytes);
  void add_chunk(std::uint64_t begin, std::uint64_t bytes);
  void add_message(std::uint64_t begin, std::uint64_t bytes);
  void add_statistics(std::uint64_t begin, std::uint64_t bytes);
  void add_channel(RecordReader record);
  void take_name(std::string_view name);
  void require_checksum(
      std::uint64_t begin, std::uint64_t end, std::uint32_t crc, const std::string& what);

  std::string path_;
  FileBytes& file_;
  bool partial_ = false;
  std::vector<BagTopic> topics_;
  std::size_t name_bytes_ = 0;  //!< of all topics
  std::vector<McapChunk> chunks_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::size_t> channels_;  //!< indices of topics_
  std::optional<McapStatistics> statistics_;
  std::uint64_t footer_ = 0;  //!< its byte
  bool is_loose_ = false;  //!< the last of chunks_ may take further messages
  bool are_closed_ = false;  //!< topics_
  std::string cut_;
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

/** A message before its payload. */
struct McapMessage
{
  std::uint16_t channel = 0;
  std::uint64_t log_time_ns = 0;

  explicit McapMessage(RecordReader& record) : channel(record.u16())
  {
    record.u32();  // its number
    log_time_ns = record.u64();
    record.u64();  // when it was published
  }
};

std::uint32_t crc_of_mcap(std::string_view bytes, std::uint32_t before = 0);

}  // namespace talus::import
