#include "bag_mcap_index.h"

#include <zlib.h>

#include <algorithm>
#include <stdexcept>

namespace talus::import
{
namespace
{
constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kRecordHead = 9;  //!< opcode and length
constexpr std::size_t kMessageHead = 22;  //!< channel, sequence, log_time, publish_time
constexpr std::uint64_t kMostLoose = std::uint64_t{1} << 22;  //!< bytes of a row in no chunk

BagPacking packing_of(std::string_view name)
{
  if (name.empty()) return BagPacking::None;
  if (name == "zstd") return BagPacking::Zstd;
  if (name == "lz4") return BagPacking::Lz4;
  throw std::runtime_error(
      "is packed with '" + std::string(name.substr(0, 24)) + "', and only zstd and lz4 are known");
}

void insert(std::vector<std::uint16_t>& channels, std::uint16_t channel)
{
  if (std::find(channels.begin(), channels.end(), channel) == channels.end())
    channels.push_back(channel);
}
}  // namespace

McapIndex::McapIndex(const std::string& path, FileBytes& file) : path_(path), file_(file)
{
  walk();
  // Channels may be declared inside of chunks only, and an index may be left out.
  for (auto& chunk : chunks_)
  {
    const bool is_known = std::all_of(
        chunk.channels.begin(), chunk.channels.end(),
        [this](std::uint16_t channel) { return channels_.count(channel) > 0; });
    if (!is_known || !chunk.is_indexed) look_into(chunk);
    for (const auto channel : chunk.channels)
      if (channels_.count(channel) == 0)
        fail(
            chunk.begin,
            "has a message of channel " + std::to_string(channel) + ", which is nowhere declared");
  }
  packed_ = {};
}

void McapIndex::walk()
{
  if (file_.look(0, kMagic.size()) != kMagic) fail(0, "is no MCAP file");
  std::uint64_t at = kMagic.size();
  for (bool is_end = false; !is_end;)
  {
    const auto head = file_.look(at, kRecordHead);
    RecordReader reader(head);
    if (head.size() < kRecordHead) fail(at, "ends in the middle of its records");
    const auto op = static_cast<McapRecord>(reader.u8());
    const std::uint64_t bytes = reader.u64(), begin = at + kRecordHead;
    if (bytes > file_.size() - begin)
      fail(at, "ends before its record of " + std::to_string(bytes) + " bytes does");
    try
    {
      add_record(op, begin, bytes);
    }
    catch (const std::runtime_error& e)
    {
      fail(at, std::string("has a record that ") + e.what());
    }
    is_end = op == McapRecord::Footer;
    at = begin + bytes;
  }
  check_end(at);
}

void McapIndex::check_end(std::uint64_t at)
{
  if (file_.look(at, kMagic.size()) != kMagic) fail(at, "does not end as an MCAP file does");
}

void McapIndex::add_record(McapRecord op, std::uint64_t begin, std::uint64_t bytes)
{
  const auto looked = [&]
  { return RecordReader(file_.look(begin, std::min<std::uint64_t>(bytes, 1 << 16))); };
  is_loose_ = is_loose_ && op == McapRecord::Message;
  switch (op)
  {
    case McapRecord::Schema:
      add_schema(looked());
      break;
    case McapRecord::Channel:
      add_channel(looked());
      break;
    case McapRecord::Message:
      add_message(begin, bytes);
      break;
    case McapRecord::Chunk:
      add_chunk(begin, bytes);
      break;
    case McapRecord::MessageIndex:
      add_message_index(begin, bytes);
      break;
    default:
      break;
  }
}

void McapIndex::add_schema(RecordReader record)
{
  const auto id = record.u16();
  schemas_[id] = std::string(record.text());
}

void McapIndex::add_channel(RecordReader record)
{
  const auto id = record.u16(), schema = record.u16();
  BagTopic topic;
  topic.name = std::string(record.text());
  topic.encoding = std::string(record.text());
  topic.type = schemas_.count(schema) > 0 ? schemas_[schema] : "";
  const auto same = std::find_if(
      topics_.begin(), topics_.end(),
      [&](const BagTopic& t) { return t.name == topic.name && t.type == topic.type; });
  const auto place = static_cast<std::size_t>(same - topics_.begin());
  const auto [known, is_new] = channels_.emplace(id, place);
  if (!is_new && known->second != place)
    throw std::runtime_error("declares channel " + std::to_string(id) + " a second time");
  if (same == topics_.end()) topics_.push_back(std::move(topic));
}

void McapIndex::add_chunk(std::uint64_t begin, std::uint64_t bytes)
{
  constexpr std::size_t kHead = 64;  // with the longest name of a packing
  const auto head = file_.look(begin, std::min<std::uint64_t>(bytes, kHead));
  RecordReader reader(head);
  McapChunk chunk;
  chunk.start_ns = reader.u64();
  reader.u64();  // its end
  chunk.bytes = reader.u64();
  chunk.crc = reader.u32();
  chunk.packing = packing_of(reader.text());
  chunk.packed_bytes = reader.u64();
  chunk.begin = begin + head.size() - reader.left();
  if (chunk.packed_bytes > begin + bytes - chunk.begin) throw std::runtime_error("is cut short");
  if (chunk.bytes > kMostBagBytes || chunk.packed_bytes > kMostBagBytes)
    throw std::runtime_error(
        "is a chunk of " + std::to_string(std::max(chunk.bytes, chunk.packed_bytes)) +
        " bytes, and no more than " + std::to_string(kMostBagBytes) +
        " are read at once: write the bag again with smaller chunks");
  chunks_.push_back(std::move(chunk));
}

/** Messages outside of chunks are read by the row, which is a chunk that is not packed. */
void McapIndex::add_message(std::uint64_t begin, std::uint64_t bytes)
{
  RecordReader head(file_.look(begin, std::min<std::uint64_t>(bytes, kMessageHead)));
  const auto channel = head.u16();
  head.u32();
  const auto log_time_ns = head.u64();
  if (bytes > kMostBagBytes)
    throw std::runtime_error("is a message of " + std::to_string(bytes) + " bytes");
  const std::uint64_t whole = bytes + kRecordHead;
  if (!is_loose_ || chunks_.back().bytes + whole > kMostLoose)
  {
    McapChunk row;
    row.begin = begin - kRecordHead;
    row.start_ns = log_time_ns;
    row.is_indexed = true;
    chunks_.push_back(std::move(row));
    is_loose_ = true;
  }
  auto& row = chunks_.back();
  row.bytes += whole;
  row.packed_bytes += whole;
  row.start_ns = std::min(row.start_ns, log_time_ns);
  insert(row.channels, channel);
}

void McapIndex::add_message_index(std::uint64_t begin, std::uint64_t bytes)
{
  RecordReader head(file_.look(begin, std::min<std::uint64_t>(bytes, 6)));
  if (chunks_.empty()) throw std::runtime_error("indexes a chunk that is not there");
  const auto channel = head.u16();
  chunks_.back().is_indexed = true;
  if (head.u32() > 0) insert(chunks_.back().channels, channel);
}

void McapIndex::look_into(McapChunk& chunk)
{
  std::vector<char> records;
  read_chunk(chunk, records);
  try
  {
    for_each_record(
        {records.data(), records.size()},
        [&](McapRecord op, std::string_view content, std::size_t)
        {
          RecordReader record(content);
          if (op == McapRecord::Schema) add_schema(record);
          if (op == McapRecord::Channel) add_channel(record);
          if (op == McapRecord::Message) insert(chunk.channels, record.u16());
        });
  }
  catch (const std::runtime_error& e)
  {
    fail(chunk.begin, std::string("has a record that ") + e.what());
  }
  chunk.is_indexed = true;
}

void McapIndex::read_chunk(const McapChunk& chunk, std::vector<char>& records)
{
  if (chunk.packing == BagPacking::None && chunk.packed_bytes != chunk.bytes)
    fail(chunk.begin, "has a chunk whose sizes do not agree");
  file_.read(
      chunk.begin, static_cast<std::size_t>(chunk.packed_bytes),
      chunk.packing == BagPacking::None ? records : packed_);
  try
  {
    if (chunk.packing != BagPacking::None)
      unpack_bag_data(chunk.packing, {packed_.data(), packed_.size()}, chunk.bytes, records);
  }
  catch (const std::runtime_error& e)
  {
    fail(chunk.begin, std::string("has a chunk that ") + e.what());
  }
  const auto crc =
      crc32(0, reinterpret_cast<const Bytef*>(records.data()), static_cast<uInt>(records.size()));
  if (chunk.crc != 0 && crc != chunk.crc)
    fail(chunk.begin, "has a chunk whose checksum does not agree");
}

std::size_t McapIndex::topic_of(std::uint16_t channel) const
{
  const auto known = channels_.find(channel);
  if (known == channels_.end())
    throw std::runtime_error(
        "is of channel " + std::to_string(channel) + ", which is nowhere declared");
  return known->second;
}

void McapIndex::fail(std::uint64_t at, const std::string& what) const
{
  throw std::runtime_error(
      path_ + ": " + what + ", at its byte " + std::to_string(at) +
      ". Copy it again; of a recording that was broken off, `mcap recover` keeps what is whole.");
}

}  // namespace talus::import
