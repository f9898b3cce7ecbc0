// What is in the chunks of an MCAP file, held against what its summary tells.
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "bag_mcap_index.h"

namespace talus::import
{
namespace
{
std::uint32_t crc_of(std::string_view records)
{
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(records.data()), static_cast<uInt>(records.size())));
}

/** Bytes of the records that are whole at the beginning. */
std::size_t whole_bytes(std::string_view records)
{
  std::size_t whole = 0;
  try
  {
    for_each_record(
        records, [&](McapRecord, std::string_view content, std::size_t begin)
        { whole = begin + content.size(); });
  }
  catch (const std::runtime_error&)
  {
    // there it is cut
  }
  return whole;
}
}  // namespace

void McapIndex::check_whole()
{
  try
  {
    summary_.check(file_);
  }
  catch (const std::runtime_error& e)
  {
    fail(summary_.footer, e.what());
  }
  if (!summary_.statistics) return;
  const auto chunks = std::count_if(
      chunks_.begin(), chunks_.end(), [](const McapChunk& chunk) { return !chunk.is_known; });
  if (summary_.statistics->chunks != chunks)
    fail(
        summary_.footer, "has " + std::to_string(chunks) + " chunks, and its Statistics tell of " +
                             std::to_string(summary_.statistics->chunks));
}

/** Whether all channels that have messages are known without a look into the chunks. */
bool McapIndex::tells_topics() const
{
  if (!cut_.empty() || !summary_.statistics) return false;
  const auto& counts = summary_.statistics->of_channel;
  const auto sum = std::accumulate(
      counts.begin(), counts.end(), std::uint64_t{0},
      [](std::uint64_t all, const auto& count) { return all + count.second; });
  return sum == summary_.statistics->messages &&
         std::all_of(
             counts.begin(), counts.end(),
             [this](const auto& count) { return channels_.count(count.first) > 0; });
}

void McapIndex::look_into_all()
{
  std::vector<char> records;
  for (auto& chunk : chunks_)
    if (!chunk.is_known) read_chunk(chunk, records);
  packed_ = {};
}

void McapIndex::unpack(const McapChunk& chunk, std::vector<char>& records)
{
  const bool is_packed = chunk.packing != BagPacking::None;
  if (!is_packed && !chunk.is_cut && chunk.packed_bytes != chunk.bytes)
    throw std::runtime_error("has a chunk whose sizes do not agree");
  file_.read(
      chunk.begin, static_cast<std::size_t>(chunk.packed_bytes), is_packed ? packed_ : records);
  try
  {
    if (is_packed)
      unpack_bag_data(
          chunk.packing, {packed_.data(), packed_.size()},
          {chunk.bytes, most_unpacked(packed_.size()), chunk.is_cut}, records);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(std::string("has a chunk that ") + e.what());
  }
  if (chunk.is_cut) return records.resize(whole_bytes({records.data(), records.size()}));
  if (chunk.crc != 0 && crc_of({records.data(), records.size()}) != chunk.crc)
    throw std::runtime_error("has a chunk whose checksum does not agree");
}

/** Its topics, and of its messages the channels, the first time, and how many there are. */
void McapIndex::learn(McapChunk& chunk, std::string_view records)
{
  std::map<std::uint16_t, std::uint64_t> counts;
  std::uint64_t first_ns = std::numeric_limits<std::uint64_t>::max();
  const auto take = [&](McapRecord op, std::string_view content, std::size_t)
  {
    RecordReader record(content);
    declare(op, record);
    if (op != McapRecord::Message) return;
    const auto channel = record.u16();
    record.u32();  // its number
    first_ns = std::min(first_ns, record.u64());
    record.u64();  // when it was published
    topic_of(channel);
    ++counts[channel];
  };
  try
  {
    for_each_record(records, take);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(std::string("has a record that ") + e.what());
  }
  for (const auto& [channel, count] : counts)
  {
    chunk.channels.push_back(channel);
    counts_[channel] += count;
  }
  if (!counts.empty()) chunk.start_ns = first_ns;
}

void McapIndex::read_chunk(McapChunk& chunk, std::vector<char>& records)
{
  const bool is_new = !chunk.is_known;
  try
  {
    unpack(chunk, records);
    if (is_new) learn(chunk, {records.data(), records.size()});
  }
  catch (const std::runtime_error& e)
  {
    if (!partial_) fail(chunk.begin, e.what());
    left_out_.push_back("byte " + std::to_string(chunk.begin) + " (" + e.what() + ")");
    records.clear();
  }
  if (!is_new) return;
  chunk.is_known = true;
  if (--unknown_ == 0 && is_open_) check_counts();
}

void McapIndex::check_counts()
{
  if (!summary_.statistics || !cut_.empty() || !left_out_.empty()) return;
  const auto total = std::accumulate(
      counts_.begin(), counts_.end(), std::uint64_t{0},
      [](std::uint64_t all, const auto& count) { return all + count.second; });
  std::string wrong;
  const auto compare = [&](std::uint64_t are, std::uint64_t told, const std::string& what)
  {
    if (are != told && wrong.empty())
      wrong = "has " + std::to_string(are) + " messages" + what + ", and its Statistics tell of " +
              std::to_string(told);
  };
  auto told = summary_.statistics->of_channel;
  if (!told.empty())
    for (const auto& [channel, count] : counts_)
      compare(count, told[channel], " of " + topics_[topic_of(channel)].name.substr(0, 100));
  for (const auto& [channel, count] : told)
    if (counts_.count(channel) == 0)
      compare(0, count, " of its channel " + std::to_string(channel));
  compare(total, summary_.statistics->messages, "");
  if (wrong.empty()) return;
  if (!partial_) fail(summary_.footer, wrong);
  cut_ = path_ + ": " + wrong;
}

std::vector<std::uint64_t> McapIndex::counts() const
{
  std::vector<std::uint64_t> of_topics(topics_.size(), 0);
  for (const auto& [channel, count] : counts_) of_topics[topic_of(channel)] += count;
  return of_topics;
}

std::vector<std::string> McapIndex::remarks() const
{
  constexpr std::size_t kMax = 5;
  std::vector<std::string> all;
  if (!cut_.empty()) all.push_back("read in part: " + cut_);
  for (std::size_t i = 0; i < std::min(left_out_.size(), kMax); ++i)
    all.push_back(path_ + ": left out is the chunk at " + left_out_[i]);
  if (left_out_.size() > kMax)
    all.push_back(path_ + ": left out are " + std::to_string(left_out_.size()) + " chunks in all");
  return all;
}

}  // namespace talus::import
