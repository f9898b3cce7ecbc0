#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace talus::io
{
/** A lock on an existing folder. It ends with the process, and with the children that it has
 * forked, however they end. */
class FolderLock
{
 public:
  /** What to do where another process has the lock. */
  enum class IfTaken
  {
    Wait,
    GiveUp
  };
  /** Throws nothing: see is_held(). */
  FolderLock(const std::filesystem::path& folder, IfTaken if_taken);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /** False where another has it, and where there is no such folder, or a file system without locks.
   */
  bool is_held() const { return error_ == 0; }
  /** Another process has it. */
  bool is_taken() const;

 private:
  int fd_ = -1, error_ = 0;
};

/** A hidden folder in another one, for what is moved there when it is complete. It is removed with
 * all that is in it; when the process is killed, it stays without its lock, and the next run
 * removes it. */
class HiddenFolder
{
 public:
  /** Its name is the prefix and six characters. Throws std::system_error. */
  HiddenFolder(const std::filesystem::path& parent, const std::string& prefix);
  ~HiddenFolder();
  HiddenFolder(const HiddenFolder&) = delete;
  HiddenFolder& operator=(const HiddenFolder&) = delete;

  /** Where it lies. */
  const std::filesystem::path& path() const { return path_; }

  /** Those in a folder; empty where it cannot be read. */
  static std::vector<std::filesystem::path> all_in(
      const std::filesystem::path& parent, const std::string& prefix);

  /** Removes those that no process holds; how many there were. */
  static std::size_t remove_abandoned(
      const std::filesystem::path& parent, const std::string& prefix);

 private:
  std::filesystem::path path_;
  std::unique_ptr<FolderLock> lock_;
};

/** Of the hidden folders in which an AtomicFile is written. */
constexpr const char* kFilePrefix = ".talus-file.";

/** A file that appears whole or not at all: written in a hidden folder beside it, then moved. What
 * was there before stays until commit() has succeeded. */
class AtomicFile
{
 public:
  /** Follows symbolic links, and removes what killed processes have left in the folder of the file.
   * Throws std::runtime_error naming the file, why it cannot be written and what to do. */
  explicit AtomicFile(const std::string& path);

  /** Where to write to: nothing yet, with the final name. */
  const std::string& temporary_path() const { return temporary_path_; }
  /** Where temporary_path() lies; what else is put there is removed with it. */
  const HiddenFolder& hidden_folder() const { return *hidden_; }

  /** Writes all bytes, after those before. Throws std::runtime_error. */
  void write(std::string_view bytes);

  /** Brings what was written to the disk and gives it its place. Throws std::runtime_error. */
  void commit();

 private:
  std::string path_, temporary_path_;
  std::unique_ptr<HiddenFolder> hidden_;
};

/** Writes all bytes into a file through AtomicFile. Throws std::runtime_error. */
void write_file(const std::string& path, std::string_view bytes);

/** Throws std::runtime_error where a folder, a device or a pipe has the name of a new file. */
void require_replaceable(const std::string& path);

/** Checks that a gz or zstd file that was just written is whole: MRPT's streams do not report when
 * their last bytes do not reach the disk. Call it after close() and before the file gets its name.
 * `name` is what messages call it, empty: `path`. Throws std::runtime_error that names it and asks
 * whether the disk is full. */
void require_complete_packed(const std::string& path, const std::string& name = "");

}  // namespace talus::io
