#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bag_file.h"

namespace talus::import
{
/** The messages of a bag of one or more files, one file after the other; where messages are packed,
 * unpacked. All throw std::runtime_error that names the file and the place. */
class BagReader
{
 public:
  /** A folder, its metadata.yaml, or one file. */
  explicit BagReader(const std::string& path);

  /** Of all files; a topic that is in several is there once. */
  const std::vector<BagTopic>& topics() const { return topics_; }

  /** From the beginning, with one flag a topic. */
  void start(std::vector<bool> wanted);
  /** From the next message on. */
  void ignore(std::size_t topic);

  bool next(BagMessage& message);
  std::string_view payload();
  /** Where the last message is, for errors, with its topic. */
  std::string place() const;
  double progress() const;

 private:
  struct File
  {
    std::unique_ptr<BagFile> file;
    std::vector<std::size_t> topics;  //!< places in topics_ of its own
  };
  void add(std::unique_ptr<BagFile> file);
  void start_file();

  std::vector<File> files_;
  std::vector<BagTopic> topics_;
  std::vector<bool> wanted_;
  std::size_t at_ = 0;  //!< the file that is being read
  std::size_t last_topic_ = 0;
  std::vector<char> unpacked_;
};

}  // namespace talus::import
