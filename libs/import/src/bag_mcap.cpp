#include <algorithm>
#include <list>
#include <optional>
#include <stdexcept>

#include "bag_file.h"
#include "bag_mcap_index.h"

namespace talus::import
{
namespace
{
/** Of chunks that overlap in time, so many bytes may be in memory at once. */
constexpr std::uint64_t kMaxOpenBytes = std::uint64_t{1} << 28;
/** And so many also where the file holds far fewer for them. */
constexpr std::uint64_t kFewOpenBytes = std::uint64_t{1} << 25;

struct Entry
{
  std::uint64_t log_time_ns = 0;
  std::uint32_t begin = 0, bytes = 0;  //!< of the payload in the records
  std::uint32_t topic = 0;
};

struct OpenChunk
{
  McapChunk* chunk = nullptr;
  std::vector<char> records;
  std::vector<Entry> entries;  //!< in order of time
  std::size_t at = 0;  //!< the next of entries

  std::uint64_t next_ns() const { return entries[at].log_time_ns; }
  bool is_done() const { return at == entries.size(); }
};

class McapFile final : public BagFile
{
 public:
  McapFile(const std::string& path, bool partial)
      : path_(path), file_(path), index_(path, file_, partial)
  {
    topics_ = index_.topics();
    file_.close();
  }

  std::uint64_t bytes() const override { return file_.size(); }
  std::vector<std::uint64_t> counts() const override { return index_.counts(); }
  std::optional<std::int64_t> first_ns() override;
  std::vector<std::string> remarks() const override { return index_.remarks(); }

  bool next(BagMessage& message) override
  {
    open_.remove_if([](const OpenChunk& chunk) { return chunk.is_done(); });
    open_what_is_due();
    if (open_.empty()) return false;
    last_ = &*std::min_element(
        open_.begin(), open_.end(),
        [](const OpenChunk& a, const OpenChunk& b) { return a.next_ns() < b.next_ns(); });
    const auto& entry = last_->entries[last_->at++];
    message.topic = entry.topic;
    message.log_time_ns = static_cast<std::int64_t>(entry.log_time_ns);
    return true;
  }

  std::string_view payload() override
  {
    const auto& entry = last_->entries[last_->at - 1];
    return {last_->records.data() + entry.begin, entry.bytes};
  }

  std::uint64_t stored_bytes() const override
  {
    const auto& entry = last_->entries[last_->at - 1];
    return std::min<std::uint64_t>(entry.bytes, last_->chunk->packed_bytes);
  }

  std::string place() const override
  {
    const auto& entry = last_->entries[last_->at - 1];
    return path_ + ": the message at byte " + std::to_string(entry.begin) +
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
  void rewind() override;
  void open_what_is_due();
  void open(McapChunk& chunk);
  bool has_wanted(const McapChunk& chunk) const;

  std::string path_;
  FileBytes file_;
  McapIndex index_;
  std::vector<McapChunk*> order_;
  std::size_t due_ = 0;  //!< the next of order_
  std::list<OpenChunk> open_;
  OpenChunk* last_ = nullptr;  //!< the chunk of the last message
};

void McapFile::rewind()
{
  stop();
  due_ = 0;
  for (auto& chunk : index_.chunks())
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
  for (const auto& chunk : index_.chunks())
    if (const auto start_ns = static_cast<std::int64_t>(chunk.start_ns);
        chunk.bytes > 0 && (!first_ns || start_ns < *first_ns))
      first_ns = start_ns;
  return first_ns;
}

/** Chunks that begin before the next message of those that are open. */
void McapFile::open_what_is_due()
{
  std::uint64_t bytes = 0, packed_bytes = 0;
  for (const auto& open : open_)
  {
    bytes += open.records.size();
    packed_bytes += open.chunk->packed_bytes;
  }
  for (; due_ < order_.size(); ++due_)
  {
    auto& chunk = *order_[due_];
    const bool is_due = std::all_of(
        open_.begin(), open_.end(),
        [&](const OpenChunk& other) { return chunk.start_ns <= other.next_ns(); });
    bytes += chunk.bytes;
    packed_bytes += chunk.packed_bytes;
    const auto most = std::min(kMaxOpenBytes, std::max(kFewOpenBytes, 4 * packed_bytes));
    if (!open_.empty() && (!is_due || bytes > most)) return;
    if (has_wanted(chunk)) open(chunk);
  }
}

void McapFile::open(McapChunk& chunk)
{
  OpenChunk opened;
  opened.chunk = &chunk;
  index_.read_chunk(chunk, opened.records);
  const auto take = [&](McapRecord op, std::string_view content, std::size_t begin)
  {
    if (op != McapRecord::Message) return;
    RecordReader record(content);
    const auto topic = index_.topic_of(record.u16());
    record.u32();  // its number
    const auto log_time_ns = record.u64();
    record.u64();  // when it was published
    if (!is_wanted(topic)) return;
    const auto head = content.size() - record.left();
    opened.entries.push_back(
        {log_time_ns, static_cast<std::uint32_t>(begin + head),
         static_cast<std::uint32_t>(record.left()), static_cast<std::uint32_t>(topic)});
  };
  try
  {
    for_each_record({opened.records.data(), opened.records.size()}, take);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(
        path_ + ": the records from byte " + std::to_string(chunk.begin) + " on have one that " +
        e.what() + ". Copy the bag again.");
  }
  std::stable_sort(
      opened.entries.begin(), opened.entries.end(),
      [](const Entry& a, const Entry& b) { return a.log_time_ns < b.log_time_ns; });
  if (!opened.entries.empty()) open_.push_back(std::move(opened));
}
}  // namespace

std::unique_ptr<BagFile> open_mcap_bag(const std::string& path, bool partial)
{
  return std::make_unique<McapFile>(path, partial);
}

}  // namespace talus::import
