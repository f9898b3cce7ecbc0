#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace talus::io
{
/** A lock on a folder, among the processes that ask for one. It ends with the process, and with the
 * children that it has forked, however they end. */
class FolderLock
{
 public:
  /** What to do where another has the lock. */
  enum class IfTaken
  {
    /** Until it is given up. */
    Wait,
    /** is_held() is false then. */
    GiveUp
  };
  /** Of an existing folder. Throws nothing: see is_held(). */
  FolderLock(const std::filesystem::path& folder, IfTaken if_taken);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /** False where another has it, where the folder is gone, and where the file system knows no
   * locks. */
  bool is_held() const { return state_ == State::Held; }
  /** Whether another has it, or the folder is gone. */
  bool is_lost() const { return state_ == State::Taken || state_ == State::Gone; }

 private:
  enum class State
  {
    Held,
    Taken,
    Gone,
    NoLocks
  };
  int fd_ = -1;
  State state_ = State::NoLocks;
};

/** A hidden folder in another one, for what is to be moved there when it is complete. It is removed
 * with all that is in it; when the process is killed, it stays, and the lock shows that nobody
 * needs it any more. */
class HiddenFolder
{
 public:
  /** Its name is the prefix, which ends in a dot, and six characters. Throws std::system_error. */
  HiddenFolder(const std::filesystem::path& parent, const std::string& prefix);
  ~HiddenFolder();
  HiddenFolder(const HiddenFolder&) = delete;
  HiddenFolder& operator=(const HiddenFolder&) = delete;

  /** Where it is. */
  const std::filesystem::path& path() const { return path_; }

  /** remove_if_abandoned() leaves it alone as long as there is something at `path`. Throws
   * std::system_error. */
  void keep_while_exists(const std::filesystem::path& path) const;

  /** Those of this user in a folder; empty where it cannot be read. */
  static std::vector<std::filesystem::path> all_in(
      const std::filesystem::path& parent, const std::string& prefix);

  /** Removes one that no process holds. False where it is left. */
  static bool remove_if_abandoned(const std::filesystem::path& hidden);

 private:
  std::filesystem::path path_;
  std::unique_ptr<FolderLock> lock_;
};

}  // namespace talus::io
