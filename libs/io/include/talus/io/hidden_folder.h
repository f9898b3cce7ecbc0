#pragma once
#include <filesystem>
#include <memory>
#include <string>
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

}  // namespace talus::io
