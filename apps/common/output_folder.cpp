#include "output_folder.h"

#include "child_process.h"
#include "export/export_formats.h"
#include "run_app.h"

#include <talus/io/atomic_file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <regex>
#include <stdexcept>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
constexpr const char* kRunPrefix = ".talus-run.";  // of hidden folders of results
constexpr const char* kMoves = ".talus-moves";  // in one whose results are being moved
constexpr const char* kSiteStem = "(site|traffic)(_floor_[0-9]+)?(_island_[0-9]+)?";

bool matches(const fs::path& name, const std::regex& pattern)
{
  return std::regex_match(name.string(), pattern);
}

/** The results in a hidden folder, relative to it, without what a run keeps for itself there
 * (".talus-..."). */
std::vector<fs::path> files_below(const fs::path& folder)
{
  std::vector<fs::path> files;
  for (auto it = fs::recursive_directory_iterator(folder); it != fs::recursive_directory_iterator();
       ++it)
    if (it->path().filename().string().rfind(".talus-", 0) == 0)
      it.disable_recursion_pending();
    else if (!it->is_directory())
      files.push_back(it->path().lexically_relative(folder));
  return files;
}

/** What of a run before would be taken for a part of the results, and is not replaced. */
std::vector<fs::path> outdated(const fs::path& hidden, const std::set<std::string>& seals)
{
  const fs::path folder = hidden.parent_path(), snapshots = "frames";
  const bool has_site = fs::exists(hidden / "site.tif"), has_labels = seals.count(kLabelTable) > 0;
  const bool replaces_site = has_site && fs::exists(folder / "site.tif");
  std::vector<fs::path> old;
  std::error_code none;
  const auto add = [&](const fs::path& in, const auto& is_old)
  {
    for (const auto& entry : fs::directory_iterator(in, none))
      if (const fs::path file = entry.path().lexically_relative(folder);
          is_old(file.filename()) && entry.is_regular_file(none) && !fs::exists(hidden / file))
        old.push_back(file);
  };
  add(folder,
      [&](const fs::path& name)
      {
        const bool is_label = name.extension() == ".label" || name == kLabelledLog;
        return (has_site && is_site_file(name)) || (has_labels && is_label) ||
               std::any_of(
                   seals.begin(), seals.end(),
                   [&](const std::string& seal) { return is_part(name, seal); }) ||
               (replaces_site && is_export(name) && name.extension() != ".qml");
      });
  static const std::regex snapshot("frame_[0-9]{6,}\\.(tif|png)");
  if (fs::exists(hidden / snapshots))
    add(folder / snapshots, [](const fs::path& name) { return matches(name, snapshot); });
  return old;
}

/** Throws before anything is changed. */
void make_room_for(const fs::path& file)
{
  io::require_replaceable(file.string());
  fs::create_directories(file.parent_path());
  if (::access(file.parent_path().c_str(), W_OK) != 0)
    throw std::runtime_error(
        file.string() + ": cannot be written: " + std::generic_category().message(errno));
}

/** Moves results, all of which are written, to their place; goes on where a run was killed that did
 * so. False where nothing is to be moved, or, unless it is this run's own, out of the folder: who
 * knows who packed the archive that it came from. */
bool move_results(const fs::path& hidden, bool is_own)
{
  const fs::path folder = hidden.parent_path(), real = fs::weakly_canonical(folder);
  if (!fs::is_regular_file(hidden / kMoves)) return false;
  std::ifstream moves(hidden / kMoves, std::ios::binary);
  const std::vector<fs::path> files = files_below(hidden);
  std::vector<fs::path> seals, old, all = files;
  for (std::string move; std::getline(moves, move, '\0') && !move.empty();
       all.emplace_back(move.substr(1)))
    (move[0] == '+' ? seals : old).emplace_back(move.substr(1));
  const auto leads_out = [&](const fs::path& file)
  {
    return file.is_absolute() ||
           fs::weakly_canonical((folder / file).parent_path()) != (real / file).parent_path();
  };
  if (!is_own && std::any_of(all.begin(), all.end(), leads_out)) return false;
  for (const fs::path& seal : seals)
    if (fs::exists(hidden / seal)) fs::remove(folder / seal);
  for (const fs::path& file : old) fs::remove(folder / file);
  std::reverse(seals.begin(), seals.end());
  for (const fs::path& file : files)
    if (std::count(seals.begin(), seals.end(), file) == 0) fs::rename(hidden / file, folder / file);
  for (const fs::path& seal : seals)
    if (fs::exists(hidden / seal)) fs::rename(hidden / seal, folder / seal);
  return true;
}

/** Finishes what killed runs had begun to move, and removes what else they left. */
void tidy_up(const fs::path& folder, const std::string& name)
{
  bool is_moved = false;
  for (const fs::path& hidden : io::HiddenFolder::all_in(folder, kRunPrefix))
    if (const io::FolderLock lock(hidden, io::FolderLock::IfTaken::GiveUp); lock.is_held())
      is_moved |= move_results(hidden, false);
  if (io::HiddenFolder::remove_abandoned(folder, kRunPrefix) +
          io::HiddenFolder::remove_abandoned(folder, io::kFilePrefix) >
      0)
    print_error(
        "warning: " + name + ": " + (is_moved ? "put in place" : "removed") +
        " what a run that was killed had left there");
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
    const io::FolderLock lock(folder_, io::FolderLock::IfTaken::Wait);
    tidy_up(folder_, name_);
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

void OutputFolder::make_sure_it_exists()
{
  if (fs::exists(hidden_->path())) return;
  fs::create_directories(folder_);
  hidden_ = std::make_unique<io::HiddenFolder>(folder_, kRunPrefix);
}

void OutputFolder::remove_made_folders() noexcept
{
  std::error_code has_files;
  for (const fs::path& folder : made_) fs::remove(folder, has_files);
}

std::string OutputFolder::shown(std::string error) const
{
  const std::string hidden = staging();
  for (auto at = error.find(hidden); at != std::string::npos;
       at = error.find(hidden, at + name_.size()))
    error.replace(at, hidden.size(), name_);
  return error;
}

void OutputFolder::commit(const std::set<std::string>& seals)
{
  const io::FolderLock lock(folder_, io::FolderLock::IfTaken::Wait);  // one run after the other
  const fs::path hidden = hidden_->path();
  try
  {
    tidy_up(folder_, name_);  // what was to be there before
    for (const std::string& seal : seals)
      if (!fs::exists(hidden / seal))
        throw std::runtime_error((hidden / seal).string() + ": was not written");
    const std::vector<fs::path> files = files_below(hidden);
    for (const fs::path& file : files) make_room_for(folder_ / file);
    const std::vector<fs::path> old = outdated(hidden, seals);
    if (files.size() == 1 && old.empty())  // takes the place of another at once
      return fs::rename(hidden / files[0], folder_ / files[0]);
    std::string moves;
    for (auto seal = seals.rbegin(); seal != seals.rend(); ++seal) moves += '+' + *seal + '\0';
    for (const fs::path& file : old) moves += '-' + file.string() + '\0';
    io::write_file(hidden / kMoves, moves);  // a run that is killed from here on is finished later
    move_results(hidden, true);
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(shown(e.what()));
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

bool is_part(const fs::path& name, const fs::path& map)
{
  const std::string stem = map.stem().string(), whole = name.filename().string();
  static const std::regex number("((_floor|_island)_[0-9]+){1,2}\\.(tiff?|png)");
  const bool ends_with_tif = matches(map.extension(), std::regex("\\.tiff?"));
  return ends_with_tif && whole.rfind(stem, 0) == 0 &&
         std::regex_match(whole.substr(stem.size()), number);
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
  const auto report = [&](const std::string& text) { print_error(output.shown(text)); };
  const int code = run_command_in_child(input, advice, work, report);
  if (code == 0) output.commit(seal);
  return code;
}

}  // namespace talus::app
