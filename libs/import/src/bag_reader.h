#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bag_file.h"

namespace talus::import
{
struct FilesOfBag
{
  std::vector<std::string> files;
  std::map<std::string, std::uint64_t> stated;  //!< messages by topic; empty: not stated
  std::vector<std::string> remarks;  //!< what a person should know, a sentence each
};

/** Of each path what metadata.yaml names, or all .db3 and .mcap of a folder where it names none;
 * the path itself where it is a file. Each file is there once. Those without a byte are left out
 * where there are others. Throws std::runtime_error where one is missing or packed as a whole. */
FilesOfBag files_of_bags(const std::vector<std::string>& paths);

/** The messages of a bag of one or more files in the order of recording, also where files overlap;
 * where messages are packed, unpacked. All throw std::runtime_error that names the file and the
 * place. */
class BagReader
{
 public:
  /** Folders, their metadata.yaml, or files. `partial`: of files that are cut, what is before the
   * cut. */
  BagReader(const std::vector<std::string>& paths, bool partial);

  /** Of all files; a topic that is in several is there once. */
  const std::vector<BagTopic>& topics() const { return topics_; }

  /** Of all files together. */
  std::uint64_t bytes() const;

  /** From the beginning, with one flag a topic. */
  void start(std::vector<bool> wanted);
  /** From the next message on. */
  void ignore(std::size_t topic);

  bool next(BagMessage& message);
  std::string_view payload();
  /** That of the last message. */
  std::size_t file() const { return static_cast<std::size_t>(last_ - files_.data()); }
  const std::string& path_of(std::size_t file) const { return files_[file].path; }
  /** Bytes of its file that hold the last message, be they packed. */
  std::uint64_t stored_bytes() const { return last_->file->stored_bytes(); }
  /** Where the last message is, for errors, with its topic. */
  std::string place() const;
  double progress() const;

  /** What a person should know of how it was read; complete once next() gave false. */
  std::vector<std::string> remarks() const;

 private:
  struct File
  {
    std::string path;
    std::unique_ptr<BagFile> file;
    std::vector<std::size_t> topics;  //!< indices of topics_ of its own
    std::int64_t first_ns = 0;
    std::optional<BagMessage> pending;  //!< its next one; topic is an index of topics_
  };
  void add(const std::string& path, bool partial);
  void start_file(File& file);
  void take_next(File& file);
  File* earliest() const;
  void compare_counts(std::vector<std::string>& remarks) const;

  std::vector<File> files_;  //!< in the order of their first messages
  std::vector<std::string> remarks_;
  std::map<std::string, std::uint64_t> stated_;  //!< messages by topic, by metadata.yaml
  std::vector<BagTopic> topics_;
  std::vector<bool> wanted_;
  std::size_t due_ = 0;  //!< the next of files_ to be started
  std::vector<File*> open_;  //!< begun and not at their end
  File* last_ = nullptr;  //!< that of the last message
  std::vector<char> unpacked_;
};

}  // namespace talus::import
