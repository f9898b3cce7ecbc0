#include "bag_reader.h"

#include <talus/input_file.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "bag_folder.h"
#include "bag_unpack.h"

namespace talus::import
{
std::unique_ptr<BagFile> open_bag_file(const std::string& path)
{
  require_readable_file(path, "bag");
  std::string begin(16, '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), 16);
  if (begin.compare(0, 15, "SQLite format 3") == 0) return open_sqlite_bag(path);
  if (begin.compare(1, 4, "MCAP") == 0) return open_mcap_bag(path);
  throw std::runtime_error(
      path + ": does not begin as a bag of ROS 2 does (SQLite or MCAP). Copy it again.");
}

BagReader::BagReader(const std::string& path)
{
  for (const auto& file : files_of_bag(path)) add(open_bag_file(file));
}

void BagReader::add(std::unique_ptr<BagFile> file)
{
  File added;
  for (const auto& topic : file->topics())
  {
    const auto same = std::find_if(
        topics_.begin(), topics_.end(),
        [&](const BagTopic& t) { return t.name == topic.name && t.type == topic.type; });
    added.topics.push_back(static_cast<std::size_t>(same - topics_.begin()));
    if (same == topics_.end()) topics_.push_back(topic);
  }
  added.file = std::move(file);
  files_.push_back(std::move(added));
}

void BagReader::start(std::vector<bool> wanted)
{
  if (at_ < files_.size()) files_[at_].file->stop();
  wanted_ = std::move(wanted);
  at_ = 0;
  start_file();
}

void BagReader::start_file()
{
  std::vector<bool> wanted;
  wanted.reserve(files_[at_].topics.size());
  for (const auto topic : files_[at_].topics) wanted.push_back(wanted_[topic]);
  files_[at_].file->start(std::move(wanted));
}

void BagReader::ignore(std::size_t topic)
{
  wanted_[topic] = false;
  const auto& file = files_[at_];
  for (std::size_t i = 0; i < file.topics.size(); ++i)
    if (file.topics[i] == topic) file.file->ignore(i);
}

bool BagReader::next(BagMessage& message)
{
  for (; at_ < files_.size();)
  {
    auto& file = files_[at_];
    if (file.file->next(message))
    {
      last_topic_ = message.topic = file.topics[message.topic];
      return true;
    }
    file.file->stop();
    if (++at_ < files_.size()) start_file();
  }
  return false;
}

std::string_view BagReader::payload()
{
  const auto data = files_[at_].file->payload();
  if (!is_zstd(data)) return data;  // a message in CDR begins with a zero
  try
  {
    unpack_bag_data(BagPacking::Zstd, data, std::nullopt, unpacked_);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(place() + ": its " + e.what() + ". Copy the bag again.");
  }
  return {unpacked_.data(), unpacked_.size()};
}

std::string BagReader::place() const
{
  return files_[at_].file->place() + " of topic " + topics_[last_topic_].name;
}

double BagReader::progress() const
{
  if (at_ == files_.size()) return 1;
  return (static_cast<double>(at_) + files_[at_].file->progress()) /
         static_cast<double>(files_.size());
}

}  // namespace talus::import
