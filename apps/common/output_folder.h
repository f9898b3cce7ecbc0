#pragma once
#include <talus/io/atomic_file.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace talus::app
{
/** A folder whose new files appear together at the end, or not at all: they are written into a
 * hidden folder inside of it and moved by commit(). Until then, and when anything fails, what was
 * there before stays as it is; folders that were made for nothing are removed. What runs that were
 * killed have left there is ended first, and told on stderr. */
class OutputFolder
{
 public:
  /** Makes the folder and the hidden one. Throws std::runtime_error that says why nothing can be
   * written there and what to do: `option` names it. From now on a limit on the size of files, or
   * nobody who reads what is printed, is an error of write(), no signal that ends the program and
   * leaves the hidden folder behind. */
  explicit OutputFolder(const std::string& folder, std::string option = "--output");
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /** Where to write. */
  std::string staging() const { return hidden_->path().string(); }

  /** One file at another place that appears with the others. Throws std::runtime_error. */
  io::AtomicFile& elsewhere(const std::string& path);

  /** What an error says of a file in staging(), by the name that the user knows. */
  std::string told(std::string error) const;

  /** Moves everything out of staging(); files of the same name are replaced. `seal` is the file in
   * it that says that the results are complete: without it the folder has none. Throws
   * std::runtime_error; then nothing has changed. */
  void commit(const std::string& seal);

 private:
  void make_folders(bool may_vanish);
  void sweep_and_tell();
  void remove_made_folders() noexcept;

  [[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) const;

  std::string name_;  //!< of the folder, as given
  std::string option_;  //!< of the command line, that names it
  std::filesystem::path folder_;
  std::unique_ptr<io::HiddenFolder> hidden_;
  std::unique_ptr<io::AtomicFile> elsewhere_;
  std::vector<std::filesystem::path> made_;  //!< folders that did not exist before, outermost first
};

/** Throws std::runtime_error when no OutputFolder could be made there; leaves nothing behind. */
inline void require_writable(const std::string& folder) { const OutputFolder trial(folder); }

/** Whether two paths, which need not exist, lead to one file. */
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/** Throws std::runtime_error when a file that is to be written is one of those that are read. */
void require_apart(const std::string& output, const std::vector<std::string>& inputs);

/** The same for the results of these names in a folder. */
void require_results_apart(
    const std::string& folder, const std::vector<std::string>& names,
    const std::vector<std::string>& inputs);

}  // namespace talus::app
