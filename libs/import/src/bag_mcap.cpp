#include <algorithm>
#include <list>
#include <map>
#include <optional>
#include <stdexcept>

#include "bag_file.h"
#include "bag_mcap_index.h"

namespace talus::import
{
namespace
{
/** Of chunks that overlap in time, the maximum in memory at once [bytes]. */
constexpr std::uint64_t kMaxOpenBytes = std::uint64_t{1} << 28;
/** And the minimum, also where the file holds far fewer for them. */
constexpr std::uint64_t kFewOpenBytes = std::uint64_t{1} << 25;

struct Entry
{
  std::uint64_t log_time_ns = 0;
  std::uint32_t begin = 0, bytes = 0;  //!< of the payload in the records
  std::size_t topic = 0;
};

struct OpenChunk
{
  McapChunk* chunk = nullptr;
  std::vector<char> records;
  std::vector<Entry> entries;  //!< in order of time
  std::size_t at = 0;  //!< the next of entries

  std::uint64_t next_ns() const { return entries[at].log_time_ns; }
};

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

class McapFile final : public BagFile
{
 public:
  McapFile(const std::string& path, bool partial);

  std::uint64_t bytes() const override { return file_.size(); }
  std::vector<std::uint64_t> counts() const override;
  std::optional<std::int64_t> first_ns() override;
  std::vector<std::string> remarks() const override;
  bool next(BagMessage& message) override;
  std::string_view payload() override
  {
    return {last_->records.data() + last_entry().begin, last_entry().bytes};
  }
  std::uint64_t stored_bytes() const override
  {
    return std::min<std::uint64_t>(last_entry().bytes, last_->chunk->packed_bytes);
  }
  std::string place() const override
  {
    return path_ + ": the message at byte " + std::to_string(last_entry().begin) +
           " of the records from byte " + std::to_string(last_->chunk->begin) + " on";
  }
  double progress() const override
  {
    return order_.empty() ? 1 : static_cast<double>(due_) / static_cast<double>(order_.size());
  }
  void stop() override
  {
    open_.clear();
    order_.clear();
    file_.close();
  }

 private:
  const Entry& last_entry() const { return last_->entries[last_->at - 1]; }
  void rewind() override;
  bool has_wanted(const McapChunk& chunk) const;
  void open_what_is_due();
  OpenChunk read(McapChunk& chunk, bool keeps_wanted);
  void unpack(OpenChunk& chunk);
  void sort_entries(OpenChunk& chunk, bool keeps_wanted);
  void learn(McapChunk& chunk, const std::map<std::uint16_t, std::uint64_t>& counts);
  void check_counts();

  std::string path_;
  FileBytes file_;
  bool partial_;
  McapIndex index_;
  std::map<std::uint16_t, std::uint64_t> counts_;  //!< messages in known chunks, by channel
  std::size_t unknown_ = 0;  //!< chunks that were not read
  std::vector<std::string> left_out_;  //!< chunks that are damaged
  std::vector<char> packed_;
  std::vector<McapChunk*> order_;
  std::size_t due_ = 0;  //!< the next of order_
  std::list<OpenChunk> open_;
  OpenChunk* last_ = nullptr;  //!< the chunk of the last message
};

McapFile::McapFile(const std::string& path, bool partial)
    : path_(path), file_(path), partial_(partial), index_(path, file_, partial)
{
  unknown_ = index_.chunks().size();
  if (unknown_ == 0) check_counts();
  if (!index_.has_all_topics())
    for (McapChunk& chunk : index_.chunks()) read(chunk, false);
  index_.close_topics();
  topics_ = index_.topics();
  packed_ = {};
  file_.close();
}

bool McapFile::next(BagMessage& message)
{
  open_.remove_if([](const OpenChunk& chunk) { return chunk.at == chunk.entries.size(); });
  open_what_is_due();
  if (open_.empty()) return false;
  last_ = &*std::min_element(
      open_.begin(), open_.end(),
      [](const OpenChunk& a, const OpenChunk& b) { return a.next_ns() < b.next_ns(); });
  const Entry& entry = last_->entries[last_->at++];
  message.topic = entry.topic;
  message.log_time_ns = static_cast<std::int64_t>(entry.log_time_ns);
  return true;
}

void McapFile::rewind()
{
  stop();
  due_ = 0;
  for (McapChunk& chunk : index_.chunks())
    if (has_wanted(chunk)) order_.push_back(&chunk);
  std::stable_sort(
      order_.begin(), order_.end(),
      [](const McapChunk* a, const McapChunk* b) { return a->start_ns < b->start_ns; });
}

bool McapFile::has_wanted(const McapChunk& chunk) const
{
  return !chunk.is_known ||
         std::any_of(
             chunk.channels.begin(), chunk.channels.end(),
             [this](std::uint16_t channel) { return is_wanted(index_.topic_of(channel)); });
}

std::optional<std::int64_t> McapFile::first_ns()
{
  std::optional<std::int64_t> first_ns;
  for (const McapChunk& chunk : index_.chunks())
    if (const auto start_ns = static_cast<std::int64_t>(chunk.start_ns);
        chunk.bytes > 0 && (!first_ns || start_ns < *first_ns))
      first_ns = start_ns;
  return first_ns;
}

/** Chunks that begin before the next message of those that are open. */
void McapFile::open_what_is_due()
{
  std::uint64_t bytes = 0, packed_bytes = 0;
  for (const OpenChunk& open : open_)
  {
    bytes += open.records.size();
    packed_bytes += open.chunk->packed_bytes;
  }
  for (; due_ < order_.size(); ++due_)
  {
    McapChunk& chunk = *order_[due_];
    const bool is_due = std::all_of(
        open_.begin(), open_.end(),
        [&](const OpenChunk& other) { return chunk.start_ns <= other.next_ns(); });
    bytes += chunk.bytes;
    packed_bytes += chunk.packed_bytes;
    const auto most = std::min(kMaxOpenBytes, std::max(kFewOpenBytes, 4 * packed_bytes));
    if (!open_.empty() && (!is_due || bytes > most)) return;
    if (!has_wanted(chunk)) continue;
    if (auto opened = read(chunk, true); !opened.entries.empty())
      open_.push_back(std::move(opened));
  }
}

/** Without a message where `keeps_wanted` is false. */
OpenChunk McapFile::read(McapChunk& chunk, bool keeps_wanted)
{
  const bool is_new = !chunk.is_known;
  OpenChunk opened;
  opened.chunk = &chunk;
  try
  {
    unpack(opened);
    sort_entries(opened, keeps_wanted);
  }
  catch (const std::runtime_error& e)
  {
    if (!partial_) index_.fail(chunk.begin, e.what());
    left_out_.push_back("byte " + std::to_string(chunk.begin) + " (" + e.what() + ")");
    opened.entries.clear();
    learn(chunk, {});
  }
  if (is_new && unknown_ == 0) check_counts();
  return opened;
}

void McapFile::unpack(OpenChunk& opened)
{
  const McapChunk& chunk = *opened.chunk;
  auto& records = opened.records;
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
  if (chunk.crc != 0 && crc_of_mcap({records.data(), records.size()}) != chunk.crc)
    throw std::runtime_error("has a chunk whose checksum does not agree");
}

void McapFile::sort_entries(OpenChunk& opened, bool keeps_wanted)
{
  std::map<std::uint16_t, std::uint64_t> counts;
  const auto take = [&](McapRecord op, std::string_view content, std::size_t begin)
  {
    RecordReader record(content);
    if (!opened.chunk->is_known) index_.declare(op, record);
    if (op != McapRecord::Message) return;
    const McapMessage message(record);
    const std::size_t topic = index_.topic_of(message.channel);
    ++counts[message.channel];
    if (!keeps_wanted || !is_wanted(topic)) return;
    const std::size_t head = content.size() - record.left();
    opened.entries.push_back(
        {message.log_time_ns, static_cast<std::uint32_t>(begin + head),
         static_cast<std::uint32_t>(record.left()), topic});
  };
  try
  {
    for_each_record({opened.records.data(), opened.records.size()}, take);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(std::string("has a record that ") + e.what());
  }
  std::stable_sort(
      opened.entries.begin(), opened.entries.end(),
      [](const Entry& a, const Entry& b) { return a.log_time_ns < b.log_time_ns; });
  learn(*opened.chunk, counts);
}

void McapFile::learn(McapChunk& chunk, const std::map<std::uint16_t, std::uint64_t>& counts)
{
  if (chunk.is_known) return;
  chunk.is_known = true;
  for (const auto& [channel, count] : counts)
  {
    chunk.channels.push_back(channel);
    counts_[channel] += count;
  }
  --unknown_;
}

void McapFile::check_counts()
{
  const auto& stated = index_.statistics();
  if (!stated || !left_out_.empty()) return;
  std::string wrong;
  const auto compare = [&](std::uint64_t are, std::uint64_t count, const std::string& what)
  {
    if (are != count && wrong.empty())
      wrong = "has " + std::to_string(are) + what + ", and its Statistics count " +
              std::to_string(count);
  };
  const auto& chunks = index_.chunks();
  compare(
      static_cast<std::uint64_t>(std::count_if(
          chunks.begin(), chunks.end(), [](const McapChunk& chunk) { return !chunk.is_loose; })),
      stated->chunks, " chunks");
  auto of_channel = stated->of_channel;
  std::uint64_t total = 0;
  for (const auto& [channel, count] : counts_)
  {
    total += count;
    if (!of_channel.empty())
      compare(
          count, of_channel[channel],
          " messages of " + index_.topics()[index_.topic_of(channel)].name.substr(0, 100));
  }
  for (const auto& [channel, count] : of_channel)
    if (counts_.count(channel) == 0)
      compare(0, count, " messages of its channel " + std::to_string(channel));
  compare(total, stated->messages, " messages");
  if (!wrong.empty()) index_.fail_at_end(wrong);
}

std::vector<std::uint64_t> McapFile::counts() const
{
  std::vector<std::uint64_t> of_topics(topics_.size(), 0);
  for (const auto& [channel, count] : counts_) of_topics[index_.topic_of(channel)] += count;
  return of_topics;
}

std::vector<std::string> McapFile::remarks() const
{
  constexpr std::size_t kMax = 5;
  std::vector<std::string> all;
  if (!index_.cut().empty()) all.push_back("read in part: " + index_.cut());
  for (std::size_t i = 0; i < std::min(left_out_.size(), kMax); ++i)
    all.push_back(path_ + ": left out is the chunk at " + left_out_[i]);
  if (left_out_.size() > kMax)
    all.push_back(path_ + ": left out are " + std::to_string(left_out_.size()) + " chunks in all");
  return all;
}
}  // namespace

std::unique_ptr<BagFile> open_mcap_bag(const std::string& path, bool partial)
{
  return std::make_unique<McapFile>(path, partial);
}

}  // namespace talus::import
