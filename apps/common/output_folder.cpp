#include "output_folder.h"

#include "child_process.h"
#include "export/export_formats.h"
#include "run_app.h"

#include <talus/io/atomic_file.h>
#include <unistd.h>

#include <cerrno>
#include <iostream>
#include <regex>
#include <stdexcept>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
using io::FolderLock;

constexpr const char* kRunPrefix = ".talus-run.";  // of hidden folders of results
constexpr const char* kSiteStem = "(site|traffic)(_floor_[0-9]+)?(_island_[0-9]+)?";
// In the hidden folder:
constexpr const char* kSeal = ".talus-seal";  // folder; the seal is in it once all is complete
constexpr const char* kToClear = ".talus-to-clear";  // until what would mislead has been removed
constexpr const char* kExports =
    "exports";  // in it, where a site map is replaced: also those of it

bool matches(const fs::path& name, const std::regex& pattern)
{
  return std::regex_match(name.string(), pattern);
}

/** Everything below a folder but folders and what a run keeps for itself (".talus-..."), relative
 * to it. */
std::vector<fs::path> files_below(const fs::path& folder)
{
  std::vector<fs::path> files;
  std::error_code gone;
  for (auto it = fs::recursive_directory_iterator(folder, gone);
       it != fs::recursive_directory_iterator(); ++it)
    if (it->path().filename().string().rfind(".talus-", 0) == 0)
      it.disable_recursion_pending();
    else if (std::error_code no_folder; !it->is_directory(no_folder))
      files.push_back(it->path().lexically_relative(folder));
  return files;
}

/** Whether a file of this name is that of another floor or island of the one that is sealed. */
bool is_part(const fs::path& name, const fs::path& sealed)
{
  const std::string stem = sealed.stem().string(), whole = name.filename().string();
  static const std::regex number("((_floor|_island)_[0-9]+){1,2}\\.[a-z]+");
  return whole.rfind(stem, 0) == 0 &&
         (name.extension() == sealed.extension() ||
          (name.extension() == ".png" && sealed.extension() == ".tif")) &&
         std::regex_match(whole.substr(stem.size()), number);
}

/** Removes the seal, and what of a run before would be taken for a part of these results. */
void clear(const fs::path& hidden, const std::string& seal)
{
  const fs::path folder = hidden.parent_path(), snapshots = "frames";
  const bool has_site = fs::exists(hidden / "site.tif"), has_labels = seal == kLabelTable;
  const bool has_exports = has_site && fs::exists(hidden / kToClear / kExports);
  std::vector<fs::path> old{folder / seal};
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder))
  {
    const fs::path name = entry.path().filename();
    const bool is_label = name.extension() == ".label" || name == kLabelledLog;
    if (((has_site && is_site_file(name)) || (has_labels && is_label) || is_part(name, seal) ||
         (has_exports && is_export(name) && name.extension() != ".qml")) &&
        entry.is_regular_file(none))
      old.push_back(entry.path());
  }
  const std::regex snapshot("frame_[0-9]{6,}\\.(tif|png)");
  if (fs::exists(hidden / snapshots))
    for (const auto& entry : fs::directory_iterator(folder / snapshots, none))
      if (matches(entry.path().filename(), snapshot) && entry.is_regular_file(none))
        old.push_back(entry.path());
  for (const auto& file : old) fs::remove(file);
}

/** Makes room for the results, which are complete then. Throws before anything else is changed. */
void seal_results(const fs::path& hidden, const std::string& seal)
{
  for (const auto& file : files_below(hidden))
  {
    const fs::path to = hidden.parent_path() / file;
    io::require_replaceable(to.string());
    fs::create_directories(to.parent_path());
    if (::access(to.parent_path().c_str(), W_OK) != 0)
      throw std::runtime_error(
          to.string() + ": cannot be written: " + std::generic_category().message(errno));
  }
  fs::create_directory(hidden / kToClear);
  if (fs::exists(hidden.parent_path() / "site.tif"))
    fs::create_directory(hidden / kToClear / kExports);
  fs::create_directory(hidden / kSeal);
  fs::rename(hidden / seal, hidden / kSeal / seal);
}

/** Moves results that are complete to their place; goes on where another process was killed. */
void place(const fs::path& hidden)
{
  const fs::path folder = hidden.parent_path();
  const auto seals = files_below(hidden / kSeal);
  if (seals.empty()) return;  // it was killed when all was in place
  if (fs::exists(hidden / kToClear)) clear(hidden, seals.front());
  fs::remove_all(hidden / kToClear);
  for (const auto& file : files_below(hidden)) fs::rename(hidden / file, folder / file);
  fs::rename(hidden / kSeal / seals.front(), folder / seals.front());
}
}  // namespace

OutputFolder::OutputFolder(const std::string& folder, const std::string& option)
    : name_(folder), folder_(fs::absolute(folder).lexically_normal())
{
  if (!folder_.has_filename()) folder_ = folder_.parent_path();
  std::error_code none;
  for (fs::path p = folder_; !fs::exists(p, none); p = p.parent_path()) made_.push_back(p);
  try
  {
    fs::create_directories(folder_);
    const FolderLock lock(folder_, FolderLock::IfTaken::Wait);
    sweep();
    hidden_ = std::make_unique<io::HiddenFolder>(folder_, kRunPrefix);
  }
  catch (const std::system_error& e)
  {
    remove_made_folders();
    const bool is_file = e.code() == std::errc::not_a_directory;
    throw std::runtime_error(
        folder_.string() +
        ": cannot write results there: " + (is_file ? "this is not a folder" : e.code().message()) +
        "; give a folder that you may write to with " + option);
  }
}

OutputFolder::~OutputFolder()
{
  hidden_.reset();
  remove_made_folders();
}

void OutputFolder::remove_made_folders() noexcept
{
  std::error_code has_files;
  for (const fs::path& folder : made_) fs::remove(folder, has_files);
}

/** Ends what runs that were killed have left. Needs the lock of the folder. */
void OutputFolder::sweep() const
{
  const auto warn = [this](const std::string& what) {
    std::cerr << ::program_invocation_short_name << ": warning: " << name_ << ": " << what << "\n";
  };
  std::size_t removed = io::HiddenFolder::remove_abandoned(folder_, io::kFilePrefix);
  for (const auto& hidden : io::HiddenFolder::all_in(folder_, kRunPrefix))
  {
    const FolderLock lock(hidden, FolderLock::IfTaken::GiveUp);
    if (!lock.is_held()) continue;
    const bool is_complete = !files_below(hidden / kSeal).empty();
    place(hidden);
    if (is_complete)
      warn("a run was killed while its results were put there; they are complete now");
    else
      ++removed;
    fs::remove_all(hidden);
  }
  if (removed > 0) warn("removed what a run that was killed had left there");
}

std::string OutputFolder::told(std::string error) const
{
  const std::string hidden = staging();
  for (auto at = error.find(hidden); at != std::string::npos;
       at = error.find(hidden, at + name_.size()))
    error.replace(at, hidden.size(), name_);
  return error;
}

void OutputFolder::commit(const std::string& seal)
{
  const FolderLock lock(folder_, FolderLock::IfTaken::Wait);
  try
  {
    sweep();
    seal_results(hidden_->path(), seal);
    place(hidden_->path());
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(told(e.what()));
  }
}

bool is_site_file(const fs::path& name)
{
  static const std::regex pattern(kSiteStem + std::string("(\\.tif|\\.png|_way\\.gpkg)"));
  return matches(name, pattern);
}

bool is_export(const fs::path& name, const std::string& map)
{
  const std::string text = name.string();
  std::smatch stem;
  if (!std::regex_search(
          text, stem, std::regex(map == "site" ? kSiteStem : map),
          std::regex_constants::match_continuous))
    return false;
  for (const ExportFormat& format : export_formats())
    for (const std::string& ending : format.endings)
      if (stem.suffix() == ending) return true;
  return false;
}

bool is_site_map(const fs::path& name)
{
  static const std::regex pattern("site(_floor_[0-9]+)?(_island_[0-9]+)?\\.tif");
  return matches(name, pattern);
}

bool is_same_file(const fs::path& a, const fs::path& b)
{
  std::error_code ec;
  return fs::equivalent(a, b, ec) ||
         fs::weakly_canonical(fs::absolute(a), ec) == fs::weakly_canonical(fs::absolute(b), ec);
}

void require_apart(
    const fs::path& folder, const std::vector<std::string>& outputs,
    const std::vector<std::string>& inputs)
{
  for (const std::string& output : outputs)
    for (const std::string& input : inputs)
      if (!input.empty() && is_same_file(folder / output, input))
        throw std::runtime_error(
            "'" + (folder / output).string() +
            "' would be overwritten, but it is an input; write elsewhere");
}

int make_results(
    const std::string& folder, const std::string& seal, const std::string& input,
    const std::string& advice, const std::function<void(const std::string& staging)>& make)
{
  OutputFolder output(folder);
  const auto work = [&]
  {
    make(output.staging());
    return 0;
  };
  const auto tell = [&](const std::string& text) { print_error(output.told(text)); };
  const int code = run_command_in_child(input, advice, work, tell);
  if (code == 0) output.commit(seal);
  return code;
}

}  // namespace talus::app
