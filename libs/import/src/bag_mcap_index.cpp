#include "bag_mcap_index.h"

#include <algorithm>
#include <stdexcept>

#include "bag_topics.h"

namespace talus::import
{
namespace
{
constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kMessageHead = 22;  //!< channel, sequence, log_time, publish_time
constexpr std::uint64_t kMaxLooseBytes = std::uint64_t{1} << 22;  //!< bytes of a row in no chunk

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

McapIndex::McapIndex(const std::string& path, FileBytes& file, bool partial)
    : path_(path), file_(file), partial_(partial)
{
  walk();
  unknown_ = static_cast<std::size_t>(std::count_if(
      chunks_.begin(), chunks_.end(), [](const McapChunk& chunk) { return !chunk.is_known; }));
  if (!tells_topics()) look_into_all();
  for (const auto& chunk : chunks_)
    for (const auto channel : chunk.channels)
      if (channels_.count(channel) == 0)
        fail(
            chunk.begin,
            "has a message of channel " + std::to_string(channel) + ", which is nowhere declared");
  if (unknown_ == 0) check_counts();
  is_open_ = true;
}

void McapIndex::walk()
{
  if (file_.look(0, kMagic.size()) != kMagic) fail(0, "is no MCAP file");
  std::uint64_t at = kMagic.size();
  try
  {
    while (summary_.footer == 0) at = walk_record(at);
    if (file_.look(at, kMagic.size()) != kMagic) fail(at, "does not end as an MCAP file does");
    if (at + kMagic.size() != file_.size())
      fail(at + kMagic.size(), "goes on behind its end (two files in one?)");
    check_whole();
  }
  catch (const std::runtime_error& e)
  {
    if (!partial_) throw;
    cut_ = e.what();
    if (summary_.footer == 0) take_cut_chunk(at);
  }
}

/** Gives the byte of the next one. */
std::uint64_t McapIndex::walk_record(std::uint64_t at)
{
  const auto head = file_.look(at, kMcapRecordHead);
  if (head.size() < kMcapRecordHead)
    fail(at, "ends without its end: it was cut, or its recording broken off");
  RecordReader reader(head);
  const auto op = static_cast<McapRecord>(reader.u8());
  const std::uint64_t bytes = reader.u64(), begin = at + kMcapRecordHead;
  if (bytes > file_.size() - begin)
    fail(at, "is cut: it ends before its record of " + std::to_string(bytes) + " bytes does");
  if (op == McapRecord::None) fail(at, "has a record of no kind");
  try
  {
    add_record(op, begin, bytes);
  }
  catch (const std::runtime_error& e)
  {
    fail(at, std::string("has a record that ") + e.what());
  }
  return begin + bytes;
}

/** Of a chunk in which the file ends, what is before; nothing of other records. */
void McapIndex::take_cut_chunk(std::uint64_t at)
{
  const std::uint64_t begin = at + kMcapRecordHead;
  const auto head = file_.look(at, kMcapRecordHead);
  const bool is_chunk = !head.empty() && static_cast<McapRecord>(head[0]) == McapRecord::Chunk;
  if (!is_chunk || begin >= file_.size()) return;
  try
  {
    is_loose_ = false;
    add_chunk(begin, file_.size() - begin);
  }
  catch (const std::runtime_error&)
  {
    // not even its head is whole
  }
}

void McapIndex::add_record(McapRecord op, std::uint64_t begin, std::uint64_t bytes)
{
  constexpr std::uint64_t kMaxHeadBytes = 1 << 16, kMaxStatistics = 1 << 20;
  is_loose_ = is_loose_ && op == McapRecord::Message;
  if (op == McapRecord::Message) return add_message(begin, bytes);
  if (op == McapRecord::Chunk) return add_chunk(begin, bytes);
  if (op == McapRecord::Statistics)
  {
    std::vector<char> whole;
    file_.read(begin, static_cast<std::size_t>(std::min(bytes, kMaxStatistics)), whole);
    return summary_.take(op, begin, RecordReader({whole.data(), whole.size()}));
  }
  const RecordReader record(file_.look(begin, std::min(bytes, kMaxHeadBytes)));
  declare(op, record);
  summary_.take(op, begin - kMcapRecordHead, record);
}

void McapIndex::declare(McapRecord op, RecordReader record)
{
  if (op == McapRecord::Schema) add_schema(record);
  if (op == McapRecord::Channel) add_channel(record);
}

void McapIndex::take_name(std::string_view name)
{
  name_bytes_ += name.size();
  const auto wrong = too_long_names(name_bytes_, topics_.size());
  if (!wrong.empty()) throw std::runtime_error("is one of too many: " + wrong);
}

void McapIndex::add_schema(RecordReader record)
{
  const auto id = record.u16();
  const auto name = record.text();
  if (schemas_.count(id) == 0) take_name(name);
  schemas_[id] = std::string(name);
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
  if (same != topics_.end()) return;
  if (is_open_)
    throw std::runtime_error(
        "declares a topic '" + topic.name.substr(0, 100) + "' that the summary lacks");
  for (const auto& name : {topic.name, topic.type, topic.encoding}) take_name(name);
  topics_.push_back(std::move(topic));
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
  const std::uint64_t there = begin + bytes - chunk.begin;
  chunk.is_cut = chunk.packed_bytes > there;
  if (chunk.is_cut && !partial_) throw std::runtime_error("is cut short");
  chunk.packed_bytes = std::min(chunk.packed_bytes, there);
  if (std::max(chunk.bytes, chunk.packed_bytes) > kMaxBagBytes)
    throw std::runtime_error(
        "is a chunk of " + std::to_string(std::max(chunk.bytes, chunk.packed_bytes)) +
        " bytes, and no more than " + std::to_string(kMaxBagBytes) +
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
  head.u64();  // when it was published
  if (bytes > kMaxBagBytes)
    throw std::runtime_error("is a message of " + std::to_string(bytes) + " bytes");
  const std::uint64_t whole = bytes + kMcapRecordHead;
  if (!is_loose_ || chunks_.back().bytes + whole > kMaxLooseBytes)
  {
    McapChunk row;
    row.begin = begin - kMcapRecordHead;
    row.start_ns = log_time_ns;
    row.is_known = true;
    chunks_.push_back(std::move(row));
    is_loose_ = true;
  }
  auto& row = chunks_.back();
  row.bytes += whole;
  row.packed_bytes += whole;
  row.start_ns = std::min(row.start_ns, log_time_ns);
  insert(row.channels, channel);
  ++counts_[channel];
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
      (partial_
           ? ""
           : ". Copy it again; where there is no better copy, --partial reads what is whole in "
             "it."));
}

}  // namespace talus::import
