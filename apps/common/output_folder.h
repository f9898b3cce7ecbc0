#pragma once
#include <talus/io/atomic_file.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace talus::app
{
/** A folder whose new files appear together at the end, or not at all: they are written into a
 * hidden folder inside of it and moved by commit(). Until then, and when anything fails, what was
 * there before stays as it is; folders that were made for nothing are removed. The next run
 * finishes what one that was killed had begun to move, else removes it, and says so on stderr. */
class OutputFolder
{
 public:
  /** Makes the folder and the hidden one. Throws std::runtime_error that says why nothing can be
   * written there and what to do: `option` names it. */
  explicit OutputFolder(const std::string& folder, const std::string& option = "--output");
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /** Where to write. */
  std::string staging() const { return hidden_->path().string(); }

  /** After a long time: somebody may have removed it. Then staging() is another one. */
  void make_sure_it_exists();

  /** What an error says of a file in staging(), by the name that the user knows. */
  std::string shown(std::string error) const;

  /** Moves everything out of staging(); files of the same name are replaced, and what would be
   * taken for a part of the results, such as snapshots, floors and exports of a run before, is
   * removed. `seals` are the files that say that the results are complete: they vanish first, the
   * last one before the others, and appear last, so that a run that is killed meanwhile leaves
   * none until the next run finishes it. Throws std::runtime_error; before anything has changed
   * where results cannot be replaced.
   */
  void commit(const std::set<std::string>& seals);
  void commit(const std::string& seal) { commit(std::set<std::string>{seal}); }

 private:
  void remove_made_folders() noexcept;

  std::string name_;  //!< of the folder, as given
  std::filesystem::path folder_;
  std::unique_ptr<io::HiddenFolder> hidden_;
  std::vector<std::filesystem::path> made_;  //!< folders that did not exist before, innermost first
};

/** Throws std::runtime_error when no OutputFolder could be made there; leaves nothing behind. */
inline void require_writable(const std::string& folder) { const OutputFolder trial(folder); }

/** Makes results in a child, which a damaged file or a signal may end: `make` writes into the
 * folder that it is given. The exit code; 0: they are in place. See OutputFolder::commit() for
 * `seal`, run_command_in_child() for `input` and `advice`. */
int make_results(
    const std::string& folder, const std::string& seal, const std::string& input,
    const std::string& advice, const std::function<void(const std::string& staging)>& make);

/** Of the labels of points: the table of numbers, which is their seal, and the log of clouds. */
constexpr const char* kLabelTable = "labels.yaml";
constexpr const char* kLabelledLog = "labels.rawlog";

/** Whether a file of this name belongs to a site map: site.tif, a picture, a way, traffic, another
 * floor or island. */
bool is_site_file(const std::filesystem::path& name);

/** Whether an export of a map, site.tif or another one without its ending, would be called so. Of a
 * site also those of its floors and islands. */
bool is_export(const std::filesystem::path& name, const std::string& map = "site");

/** Whether a file of this name is that of another floor or island of a map, or its picture. */
bool is_part(const std::filesystem::path& name, const std::filesystem::path& map);

/** Whether a file of this name is site.tif, or that of another floor or island. */
bool is_site_map(const std::filesystem::path& name);

/** Whether two paths, which need not exist, lead to one file. */
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/** Throws std::runtime_error when one of these files in a folder, which are to be written, is one
 * of those that are read. */
void require_apart(
    const std::filesystem::path& folder, const std::vector<std::string>& outputs,
    const std::vector<std::string>& inputs);

}  // namespace talus::app
