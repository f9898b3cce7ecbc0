#include "bag_reader.h"

#include <talus/input_file.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "bag_unpack.h"

namespace talus::import
{
std::unique_ptr<BagFile> open_bag_file(const std::string& path, bool partial)
{
  require_readable_file(path, "bag");
  std::string begin(16, '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), 16);
  if (begin.compare(0, 15, "SQLite format 3") == 0) return open_sqlite_bag(path, partial);
  if (begin.compare(1, 4, "MCAP") == 0) return open_mcap_bag(path, partial);
  throw std::runtime_error(
      path + ": does not begin as a bag of ROS 2 does (SQLite or MCAP). Copy it again.");
}

BagReader::BagReader(const std::vector<std::string>& paths, bool partial)
{
  auto bag = files_of_bags(paths);
  for (const auto& file : bag.files) add(file, partial);
  remarks_ = std::move(bag.remarks);
  stated_ = std::move(bag.stated);
  std::stable_sort(
      files_.begin(), files_.end(),
      [](const File& a, const File& b) { return a.first_ns < b.first_ns; });
}

void BagReader::add(const std::string& path, bool partial)
{
  auto file = open_bag_file(path, partial);
  File added;
  added.path = path;
  for (const auto& topic : file->topics())
  {
    const auto same = std::find_if(
        topics_.begin(), topics_.end(),
        [&](const BagTopic& t) { return t.name == topic.name && t.type == topic.type; });
    added.topics.push_back(static_cast<std::size_t>(same - topics_.begin()));
    if (same == topics_.end()) topics_.push_back(topic);
  }
  added.first_ns = file->first_ns().value_or(0);
  added.file = std::move(file);
  files_.push_back(std::move(added));
}

void BagReader::start(std::vector<bool> wanted)
{
  for (auto& file : files_)
  {
    file.file->stop();
    file.pending.reset();
  }
  wanted_ = std::move(wanted);
  due_ = 0;
  open_.clear();
  last_ = nullptr;
}

void BagReader::start_file(File& file)
{
  std::vector<bool> wanted;
  wanted.reserve(file.topics.size());
  for (const auto topic : file.topics) wanted.push_back(wanted_[topic]);
  file.file->start(std::move(wanted));
  open_.push_back(&file);
  take_next(file);
}

void BagReader::take_next(File& file)
{
  BagMessage message;
  if (file.file->next(message))
  {
    message.topic = file.topics[message.topic];
    file.pending = message;
    return;
  }
  file.pending.reset();
  file.file->stop();
  open_.erase(std::find(open_.begin(), open_.end(), &file));
}

void BagReader::ignore(std::size_t topic)
{
  wanted_[topic] = false;
  for (auto* file : open_)
    for (std::size_t i = 0; i < file->topics.size(); ++i)
      if (file->topics[i] == topic) file->file->ignore(i);
}

/** Of the files that are open the one with the next message; nothing at their end. */
BagReader::File* BagReader::earliest() const
{
  const auto first = std::min_element(
      open_.begin(), open_.end(),
      [](const File* a, const File* b)
      { return a->pending->log_time_ns < b->pending->log_time_ns; });
  return first == open_.end() ? nullptr : *first;
}

bool BagReader::next(BagMessage& message)
{
  if (last_) take_next(*last_);
  last_ = nullptr;
  while (true)
  {
    auto* file = earliest();
    if (due_ < files_.size() && (!file || files_[due_].first_ns <= file->pending->log_time_ns))
    {
      start_file(files_[due_++]);
      continue;
    }
    if (!file) return false;
    message = *file->pending;
    if (wanted_[message.topic])
    {
      last_ = file;
      return true;
    }
    take_next(*file);  // nobody wants it any more
  }
}

std::string_view BagReader::payload()
{
  const auto data = last_->file->payload();
  if (!is_zstd(data)) return data;  // a message in CDR begins with a zero
  try
  {
    unpack_bag_data(
        BagPacking::Zstd, data, {{}, most_unpacked(last_->file->stored_bytes())}, unpacked_);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(place() + ": " + e.what() + ". Copy the bag again.");
  }
  return {unpacked_.data(), unpacked_.size()};
}

std::string BagReader::place() const
{
  return last_->file->place() + " of topic " + topics_[last_->pending->topic].name;
}

double BagReader::progress() const
{
  double sum = 0;
  for (std::size_t i = 0; i < due_; ++i) sum += files_[i].pending ? files_[i].file->progress() : 1;
  return files_.empty() ? 1 : sum / static_cast<double>(files_.size());
}

std::uint64_t BagReader::bytes() const
{
  std::uint64_t sum = 0;
  for (const auto& file : files_) sum += file.file->bytes();
  return sum;
}

/** metadata.yaml is written last: where messages were lost since, it shows that. */
void BagReader::compare_counts(std::vector<std::string>& remarks) const
{
  std::map<std::string, std::uint64_t> are;
  for (const auto& file : files_)
  {
    const auto counts = file.file->counts();
    for (std::size_t i = 0; i < counts.size(); ++i) are[topics_[file.topics[i]].name] += counts[i];
  }
  for (const auto& [topic, count] : stated_)
    if (are[topic] != count)
      remarks.push_back(
          topic.substr(0, 100) + ": the messages that are there are " + std::to_string(are[topic]) +
          ", those that metadata.yaml counts " + std::to_string(count));
}

std::vector<std::string> BagReader::remarks() const
{
  auto all = remarks_;
  for (const auto& file : files_)
    for (auto& remark : file.file->remarks()) all.push_back(std::move(remark));
  compare_counts(all);
  return all;
}

}  // namespace talus::import
