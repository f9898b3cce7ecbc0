#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace talus::app
{
/** A folder whose new files appear together at the end, or not at all: they are written into a
 * hidden folder inside of it and moved by commit(). Until then, and when anything fails, what was
 * there before stays as it is; folders that were made for nothing are removed. */
class OutputFolder
{
 public:
  /** Makes the folder and the hidden one. Throws std::runtime_error that says why nothing can be
   * written there and what to do. From now on a limit on the size of files, or nobody who reads
   * what is printed, is an error of write(), no signal that ends the program and leaves the hidden
   * folder behind. */
  explicit OutputFolder(const std::string& folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /** Where to write. */
  std::string staging() const { return staging_.string(); }

  /** What an error says of a file in staging(), by the name that the user knows. */
  std::string told(std::string error) const;

  /** Moves everything out of staging(); files of the same name are replaced. Then calls `last`, a
   * step that belongs to it. Throws std::runtime_error, also what `last` throws; then nothing has
   * changed. */
  void commit(const std::function<void()>& last = {});

 private:
  using Moves = std::vector<std::pair<std::filesystem::path, std::filesystem::path>>;

  void replace(const std::filesystem::path& relative, Moves& done);
  void set_aside_old_snapshots(Moves& done);
  void make_staging(bool may_vanish);
  void remove_made_folders() noexcept;

  std::string name_;  //!< of the folder, as given
  std::filesystem::path folder_, staging_;
  std::vector<std::filesystem::path> made_;  //!< folders that did not exist before, outermost first
};

/** Throws std::runtime_error when no OutputFolder could be made there; leaves nothing behind. */
inline void require_writable(const std::string& folder) { const OutputFolder trial(folder); }

/** Throws std::runtime_error when a file that is to be written is one of those that are read. */
void require_apart(const std::string& output, const std::vector<std::string>& inputs);

}  // namespace talus::app
