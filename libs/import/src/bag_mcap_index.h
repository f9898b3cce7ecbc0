#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bag_bytes.h"
#include "bag_file.h"
#include "bag_unpack.h"

namespace talus::import
{
/** Opcodes of the records of MCAP, https://mcap.dev/spec. */
enum class McapRecord : std::uint8_t
{
  Header = 0x01,
  Footer = 0x02,
  Schema = 0x03,
  Channel = 0x04,
  Message = 0x05,
  Chunk = 0x06,
  MessageIndex = 0x07
};

/** Records in a row: a chunk, or some that are in none. */
struct McapChunk
{
  std::uint64_t begin = 0, packed_bytes = 0;  //!< in the file
  std::uint64_t bytes = 0;  //!< of the records
  std::uint64_t start_ns = 0;  //!< the first log_time in it
  std::uint32_t crc = 0;  //!< of the records; 0: not known
  BagPacking packing = BagPacking::None;
  bool is_indexed = false;  //!< channels has all that are in it
  std::vector<std::uint16_t> channels;
};

/** What is where in an MCAP file; found by going from record to record, which takes no payload into
 * memory, with or without a summary at the end. */
class McapIndex
{
 public:
  /** Throws std::runtime_error that names the file and the byte. */
  McapIndex(const std::string& path, FileBytes& file);

  const std::vector<BagTopic>& topics() const { return topics_; }
  const std::vector<McapChunk>& chunks() const { return chunks_; }

  /** Throws for one that no record declares. */
  std::size_t topic_of(std::uint16_t channel) const;

  /** The records of a chunk, unpacked, checked against their checksum. */
  void read_chunk(const McapChunk& chunk, std::vector<char>& records);

 private:
  void walk();
  void add_record(McapRecord op, std::uint64_t begin, std::uint64_t bytes);
  void add_chunk(std::uint64_t begin, std::uint64_t bytes);
  void add_message(std::uint64_t begin, std::uint64_t bytes);
  void add_message_index(std::uint64_t begin, std::uint64_t bytes);
  void add_schema(RecordReader record);
  void add_channel(RecordReader record);
  void look_into(McapChunk& chunk);
  void check_end(std::uint64_t at);
  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const;

  std::string path_;
  FileBytes& file_;
  std::vector<BagTopic> topics_;
  std::vector<McapChunk> chunks_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::size_t> channels_;  //!< places in topics_
  std::vector<char> packed_;
  bool is_loose_ = false;  //!< the last of chunks_ may take further messages
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
