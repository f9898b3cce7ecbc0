#include "bag_mcap_index.h"

#include <zlib.h>

#include <algorithm>
#include <stdexcept>

#include "bag_topics.h"

namespace talus::import
{
namespace
{
constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t kHead = 9;  //!< bytes of opcode and length
constexpr std::uint64_t kMaxLooseBytes = std::uint64_t{1} << 22;  //!< bytes of a row in no chunk

BagPacking packing_of(std::string_view name)
{
  if (name.empty()) return BagPacking::None;
  if (name == "zstd") return BagPacking::Zstd;
  if (name == "lz4") return BagPacking::Lz4;
  throw std::runtime_error(
      "is packed with '" + std::string(name.substr(0, 24)) + "', and only zstd and lz4 are known");
}
}  // namespace

std::uint32_t crc_of_mcap(std::string_view bytes, std::uint32_t before)
{
  return static_cast<std::uint32_t>(
      crc32(before, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

McapIndex::McapIndex(const std::string& path, FileBytes& file, bool partial)
    : path_(path), file_(file), partial_(partial)
{
  if (file_.look(0, kMagic.size()) != kMagic) fail(0, "is no MCAP file");
  std::uint64_t at = kMagic.size();
  try
  {
    while (footer_ == 0) at = walk_record(at);
    if (file_.look(at, kMagic.size()) != kMagic) fail(at, "does not end as an MCAP file does");
    if (at + kMagic.size() != file_.size())
      fail(at + kMagic.size(), "goes on behind its end (two files in one?)");
  }
  catch (const std::runtime_error& e)
  {
    if (!partial_) throw;
    cut_ = e.what();
    if (footer_ == 0) take_cut_chunk(at);
  }
  if (!cut_.empty()) statistics_.reset();
}

/** Gives the byte of the next one. */
std::uint64_t McapIndex::walk_record(std::uint64_t at)
{
  const auto head = file_.look(at, kHead);
  if (head.size() < kHead)
    fail(at, "ends without its end: it was cut, or its recording broken off");
  RecordReader reader(head);
  const auto op = static_cast<McapRecord>(reader.u8());
  const std::uint64_t bytes = reader.u64(), begin = at + kHead;
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
  const auto head = file_.look(at, kHead);
  const bool is_chunk = !head.empty() && static_cast<McapRecord>(head[0]) == McapRecord::Chunk;
  if (!is_chunk || at + kHead >= file_.size()) return;
  try
  {
    add_chunk(at + kHead, file_.size() - at - kHead);
  }
  catch (const std::runtime_error&)
  {
    // not even its head is whole
  }
}

void McapIndex::add_record(McapRecord op, std::uint64_t begin, std::uint64_t bytes)
{
  constexpr std::uint64_t kMaxHeadBytes = 1 << 16;
  is_loose_ = is_loose_ && op == McapRecord::Message;
  if (op == McapRecord::Message) return add_message(begin, bytes);
  if (op == McapRecord::Chunk) return add_chunk(begin, bytes);
  if (op == McapRecord::Statistics) return add_statistics(begin, bytes);
  RecordReader record(file_.look(begin, std::min(bytes, kMaxHeadBytes)));
  declare(op, record);
  if (op == McapRecord::DataEnd)
    require_checksum(0, begin - kHead, record.u32(), "its data (DataEnd)");
  if (op != McapRecord::Footer) return;
  footer_ = begin - kHead;
  const std::uint64_t summary = record.u64();
  record.u64();  // the offsets in it
  const std::uint64_t end = begin + 16;  // up to the checksum itself
  require_checksum(summary == 0 ? footer_ : summary, end, record.u32(), "its summary (Footer)");
}

void McapIndex::require_checksum(
    std::uint64_t begin, std::uint64_t end, std::uint32_t stated, const std::string& what)
{
  constexpr std::uint64_t kPart = 1 << 16;
  if (stated == 0) return;
  std::uint32_t crc = 0;
  for (std::uint64_t at = begin; at < end;)
  {
    const auto part = file_.look(at, static_cast<std::size_t>(std::min(kPart, end - at)));
    if (part.empty()) break;
    crc = crc_of_mcap(part, crc);
    at += part.size();
  }
  if (begin < end && crc == stated) return;
  cut_ = path_ + ": the checksum of " + what + " does not agree: bytes from byte " +
         std::to_string(begin) + " to " + std::to_string(end) + " were changed";
  if (!partial_) fail(end, cut_.substr(path_.size() + 2));
}

void McapIndex::add_statistics(std::uint64_t begin, std::uint64_t bytes)
{
  constexpr std::uint64_t kMaxBytes = 1 << 20;
  std::vector<char> whole;
  file_.read(begin, static_cast<std::size_t>(std::min(bytes, kMaxBytes)), whole);
  RecordReader record({whole.data(), whole.size()});
  statistics_.emplace().messages = record.u64();
  record.take(2 + 4 + 4 + 4);  // schemas, channels, attachments, metadata
  statistics_->chunks = record.u32();
  record.take(2 * 8);  // the first log_time and the last
  RecordReader counts(record.text());
  while (counts.left() > 0)
  {
    const auto channel = counts.u16();
    statistics_->of_channel[channel] = counts.u64();
  }
}

bool McapIndex::has_all_topics() const
{
  if (!statistics_) return false;
  std::uint64_t sum = 0;
  for (const auto& [channel, count] : statistics_->of_channel)
  {
    if (channels_.count(channel) == 0) return false;
    sum += count;
  }
  return sum == statistics_->messages;
}

void McapIndex::declare(McapRecord op, RecordReader record)
{
  if (op == McapRecord::Channel) add_channel(record);
  if (op != McapRecord::Schema) return;
  const auto id = record.u16();
  const auto name = record.text();
  if (schemas_.count(id) == 0) take_name(name);
  schemas_[id] = std::string(name);
}

void McapIndex::take_name(std::string_view name)
{
  name_bytes_ += name.size();
  const auto wrong = too_long_names(name_bytes_, topics_.size());
  if (!wrong.empty()) throw std::runtime_error("is one of too many: " + wrong);
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
  const auto index = static_cast<std::size_t>(same - topics_.begin());
  const auto [known, is_new] = channels_.emplace(id, index);
  if (!is_new && known->second != index)
    throw std::runtime_error("declares channel " + std::to_string(id) + " a second time");
  if (same != topics_.end()) return;
  if (are_closed_)
    throw std::runtime_error(
        "declares a topic '" + topic.name.substr(0, 100) + "' that the summary lacks");
  for (const auto& name : {topic.name, topic.type, topic.encoding}) take_name(name);
  topics_.push_back(std::move(topic));
}

void McapIndex::add_chunk(std::uint64_t begin, std::uint64_t bytes)
{
  constexpr std::size_t kChunkHead = 64;  // with the longest name of a packing
  const auto head = file_.look(begin, std::min<std::uint64_t>(bytes, kChunkHead));
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
  constexpr std::uint64_t kMessageHead = 22;
  RecordReader head(file_.look(begin, std::min(bytes, kMessageHead)));
  const McapMessage message(head);
  if (bytes > kMaxBagBytes)
    throw std::runtime_error("is a message of " + std::to_string(bytes) + " bytes");
  const std::uint64_t whole = bytes + kHead;
  if (!is_loose_ || chunks_.back().bytes + whole > kMaxLooseBytes)
  {
    chunks_.emplace_back().begin = begin - kHead;
    chunks_.back().is_loose = is_loose_ = true;
    chunks_.back().start_ns = message.log_time_ns;
  }
  auto& row = chunks_.back();
  row.bytes += whole;
  row.packed_bytes += whole;
  row.start_ns = std::min(row.start_ns, message.log_time_ns);
}

std::size_t McapIndex::topic_of(std::uint16_t channel) const
{
  const auto known = channels_.find(channel);
  if (known == channels_.end())
    throw std::runtime_error(
        "is of channel " + std::to_string(channel) + ", which is nowhere declared");
  return known->second;
}

void McapIndex::fail_at_end(const std::string& what)
{
  if (!partial_) fail(footer_, what);
  cut_ = path_ + ": " + what;
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
