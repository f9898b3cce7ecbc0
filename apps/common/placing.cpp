#include "placing.h"

#include <talus/io/atomic_file.h>
#include <talus/io/hidden_folder.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
constexpr const char* kSnapshots = "frames";

// In the hidden folder:
constexpr const char* kSeal = ".talus-seal";  // folder; the seal is in it from begin_placing() on
constexpr const char* kCleared = ".talus-cleared";  // what would mislead has been set aside
constexpr const char* kReplaced = ".talus-replaced";  // folder; what was there before
constexpr const char* kElsewhere =
    ".talus-elsewhere";  // link to the hidden folder of a file elsewhere

/** A TIFF or PNG whose name is `start` and so many digits at least. */
bool is_numbered(const fs::path& file, const std::string& start, std::size_t fewest_digits)
{
  const std::string stem = file.stem().string();
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  return (file.extension() == ".tif" || file.extension() == ".png") &&
         stem.size() >= start.size() + fewest_digits && stem.rfind(start, 0) == 0 &&
         std::all_of(
             stem.begin() + static_cast<std::ptrdiff_t>(start.size()), stem.end(), is_digit);
}
bool is_snapshot(const fs::path& file) { return is_numbered(file, "frame_", 6); }
/** The map to which the file of a way belongs: site.tif of site_way.gpkg; other files are their
 * own. */
fs::path map_of(const fs::path& file)
{
  constexpr std::string_view kWay = "_way";
  const std::string stem = file.stem().string();
  const bool is_way = file.extension() == ".gpkg" && stem.size() > kWay.size() &&
                      stem.compare(stem.size() - kWay.size(), kWay.size(), kWay) == 0;
  if (!is_way) return file;
  return file.parent_path() / (stem.substr(0, stem.size() - kWay.size()) + ".tif");
}

/** A floor or an island: site_floor_1.tif, site_island_2.png, site_floor_1_island_2.tif. */
bool is_site_part(const fs::path& file)
{
  fs::path first = file;
  if (const auto at = file.stem().string().rfind("_island_"); at != std::string::npos)
  {
    if (!is_numbered(file, file.stem().string().substr(0, at) + "_island_", 1)) return false;
    first.replace_filename(file.stem().string().substr(0, at) + file.extension().string());
    if (first.stem() == "site") return true;
  }
  return is_numbered(first, "site_floor_", 1);
}

/** traffic.tif, and those of other floors and islands. */
bool is_traffic(const fs::path& file)
{
  constexpr std::string_view kTraffic = "traffic";
  const std::string name = file.filename().string();
  if (name.rfind(kTraffic, 0) != 0 || file.extension() != ".tif") return false;
  const fs::path map = "site" + name.substr(kTraffic.size());
  return map == "site.tif" || is_site_part(map);
}

/** Everything below a folder that is neither internal nor a folder, relative to it. */
std::vector<fs::path> files_below(const fs::path& folder)
{
  std::vector<fs::path> files;
  std::error_code gone;
  for (auto it = fs::recursive_directory_iterator(folder, gone);
       it != fs::recursive_directory_iterator(); ++it)
    if (is_internal(it->path()))
      it.disable_recursion_pending();
    else if (std::error_code no_folder; !it->is_directory(no_folder))
      files.push_back(it->path().lexically_relative(folder));
  return files;
}

/** The name of the seal; empty before begin_placing(), and when everything is in place. */
fs::path seal_of(const fs::path& hidden)
{
  const auto files = files_below(hidden / kSeal);
  return files.empty() ? fs::path() : files.front();
}

/** The hidden folder of a file elsewhere, or empty. */
fs::path elsewhere_of(const fs::path& hidden)
{
  std::error_code none;
  const fs::path link = fs::read_symlink(hidden / kElsewhere, none);
  const auto known = io::HiddenFolder::all_in(link.parent_path(), io::kFilePrefix);
  return std::find(known.begin(), known.end(), link) == known.end() ? fs::path() : link;
}

void require_replaceable(const fs::path& file)
{
  if (fs::is_directory(file))
    throw std::runtime_error(
        file.string() +
        ": cannot be replaced, a folder has this name; rename it or write elsewhere");
  const auto status = fs::symlink_status(file);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_symlink(status))
    throw std::runtime_error(
        file.string() + ": cannot be replaced, it is a device or a pipe; write elsewhere");
}

void set_aside(const fs::path& hidden, const fs::path& relative, Moves& done)
{
  const fs::path file = hidden.parent_path() / relative;
  if (!fs::exists(fs::symlink_status(file))) return;
  const fs::path aside = replaced_in(hidden) / relative;
  fs::create_directories(aside.parent_path());
  done.move(file, aside);
}

/** Snapshots of another run would be taken for those of this one. */
void set_aside_old_snapshots(const fs::path& hidden, Moves& done)
{
  const fs::path snapshots = hidden.parent_path() / kSnapshots;
  if (!fs::is_directory(snapshots) || !fs::is_directory(hidden / kSnapshots)) return;
  std::vector<fs::path> old;
  std::error_code no_file;  // such as a link to itself
  for (const auto& entry : fs::directory_iterator(snapshots))
    if (is_snapshot(entry.path()) && entry.is_regular_file(no_file)) old.push_back(entry.path());
  for (const auto& file : old) set_aside(hidden, kSnapshots / file.filename(), done);
}

/** Floors, islands and the traffic of another run would be taken for those of this site map. */
void set_aside_old_parts(const fs::path& hidden, Moves& done)
{
  if (!fs::exists(hidden / "site.tif")) return;
  std::vector<fs::path> old;
  std::error_code no_file;  // such as a link to itself
  for (const auto& entry : fs::directory_iterator(hidden.parent_path()))
    if ((is_site_part(map_of(entry.path())) || is_traffic(entry.path())) &&
        entry.is_regular_file(no_file))
      old.push_back(entry.path());
  for (const auto& file : old) set_aside(hidden, file.filename(), done);
}

/** Labels of another run would be taken for those of more scans of this one. */
void set_aside_old_labels(const fs::path& hidden, const fs::path& seal, Moves& done)
{
  if (seal != kLabelTable) return;
  std::vector<fs::path> old;
  std::error_code no_file;
  for (const auto& entry : fs::directory_iterator(hidden.parent_path()))
    if ((entry.path().extension() == ".label" || entry.path().filename() == kLabelledLog) &&
        entry.is_regular_file(no_file))
      old.push_back(entry.path());
  for (const auto& file : old) set_aside(hidden, file.filename(), done);
}

/** Ends one that no other process holds. */
void end(const fs::path& hidden, Swept& swept)
{
  using IfTaken = io::FolderLock::IfTaken;
  // Only who has the lock of the folder places results: a process that did is at its end.
  const bool has_begun = !seal_of(hidden).empty();
  const io::FolderLock lock(hidden, has_begun ? IfTaken::Wait : IfTaken::GiveUp);
  if (!lock.is_held()) return;
  Moves done;
  if (has_begun) place(hidden, done);
  const fs::path elsewhere = elsewhere_of(hidden);
  std::error_code ignored;
  fs::remove_all(hidden, ignored);
  if (!elsewhere.empty()) io::HiddenFolder::remove_if_abandoned(elsewhere);
  if (has_begun)
    ++swept.placed;
  else if (!fs::exists(hidden, ignored))
    ++swept.removed;
}
}  // namespace

bool is_internal(const fs::path& path)
{
  return path.filename().string().rfind(".talus-", 0) == 0;  // other results may begin with a dot
}

bool is_site_file(const fs::path& name)
{
  const fs::path map = map_of(name);
  return map == "site.tif" || map == "site.png" || is_site_part(map) || is_traffic(name);
}

bool is_site_map(const fs::path& name)
{
  return name.extension() == ".tif" && (name == "site.tif" || is_site_part(name));
}

void Moves::move(const fs::path& from, const fs::path& to)
{
  fs::rename(from, to);
  done_.emplace_back(from, to);
}

void Moves::undo() noexcept
{
  std::error_code ignored;
  for (auto it = done_.rbegin(); it != done_.rend(); ++it)
    fs::rename(it->second, it->first, ignored);
  done_.clear();
}

fs::path replaced_in(const fs::path& hidden) { return hidden / kReplaced; }

void link_elsewhere(const fs::path& hidden, const io::HiddenFolder& elsewhere)
{
  fs::create_symlink(fs::absolute(elsewhere.path()), hidden / kElsewhere);
  elsewhere.keep_while_exists(hidden / kSeal);
}

void begin_placing(const fs::path& hidden, const std::string& seal, Moves& done)
{
  for (const auto& file : files_below(hidden)) require_replaceable(hidden.parent_path() / file);
  fs::create_directory(hidden / kSeal);
  done.move(hidden / seal, hidden / kSeal / seal);
}

void place(const fs::path& hidden, Moves& done)
{
  const fs::path folder = hidden.parent_path(), seal = seal_of(hidden);
  if (!fs::exists(hidden / kCleared))
  {
    set_aside(hidden, seal, done);
    set_aside_old_snapshots(hidden, done);
    set_aside_old_parts(hidden, done);
    set_aside_old_labels(hidden, seal, done);
    fs::create_directory(hidden / kCleared);
  }
  for (const auto& file : files_below(hidden))
  {
    require_replaceable(folder / file);
    set_aside(hidden, file, done);
    fs::create_directories((folder / file).parent_path());
    done.move(hidden / file, folder / file);
  }
  if (const fs::path elsewhere = elsewhere_of(hidden); !elsewhere.empty())
    for (const auto& file : files_below(elsewhere))
      fs::rename(elsewhere / file, elsewhere.parent_path() / file);
  done.move(hidden / kSeal / seal, folder / seal);
}

Swept sweep(const fs::path& folder)
{
  Swept swept;
  for (const auto& hidden : io::HiddenFolder::all_in(folder, kRunPrefix)) end(hidden, swept);
  swept.removed += io::remove_abandoned_files((folder / "any").string());
  return swept;
}

}  // namespace talus::app
