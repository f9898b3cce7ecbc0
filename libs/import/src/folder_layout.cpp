#include "folder_layout.h"

#include <talus/input_file.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "formats.h"

namespace fs = std::filesystem;

namespace talus::import
{
namespace
{
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/** Takes the digits that a text begins with, without zeros before them. */
std::string_view take_number(std::string_view& text)
{
  std::size_t end = 0;
  while (end < text.size() && is_digit(text[end])) ++end;
  std::string_view number = text.substr(0, end);
  text.remove_prefix(end);
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return number;
}

/** As people count: scan_9 before scan_10. */
bool is_before(std::string_view a, std::string_view b)
{
  const std::string_view whole_a = a, whole_b = b;
  while (!a.empty() && !b.empty())
  {
    if (is_digit(a[0]) && is_digit(b[0]))
    {
      const auto number_a = take_number(a), number_b = take_number(b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
      continue;
    }
    if (a[0] != b[0]) return a[0] < b[0];
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;
}

std::string name_of(const std::string& scan) { return fs::path(scan).stem().string(); }

/** The number that a name is: of digits and a point, as times are. */
void sort(std::vector<std::string>& scans)
{
  std::sort(
      scans.begin(), scans.end(),
      [](const std::string& a, const std::string& b) { return is_before(name_of(a), name_of(b)); });
  std::vector<std::pair<double, std::string>> numbered;
  for (const auto& number : numbers_of_names(scans))
    numbered.emplace_back(number_from(number).value_or(0), scans[numbered.size()]);
  std::stable_sort(
      numbered.begin(), numbered.end(),
      [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < numbered.size(); ++i) scans[i] = numbered[i].second;
}

/** The scans in a folder, by format, bags among them; those that are hidden are none. */
std::map<const Format*, std::vector<std::string>> scans_in(const fs::path& folder)
{
  std::map<const Format*, std::vector<std::string>> scans;
  std::error_code no_file;  // such as a link to itself
  for (const auto& entry : fs::directory_iterator(folder))
  {
    if (entry.path().filename().string()[0] == '.' || !entry.is_regular_file(no_file)) continue;
    const Format* format = format_by_ending(entry.path().string());
    if (format && (format->is_scan || format->open)) scans[format].push_back(entry.path().string());
  }
  return scans;
}

/** The first of the files that is there, or "". */
std::string first_of(const std::vector<fs::path>& files)
{
  std::error_code ignored;
  for (const auto& file : files)
    if (fs::is_regular_file(file, ignored)) return file.string();
  return "";
}

/** Without a slash at its end, and with a name even where it is `.`. */
fs::path full(const fs::path& path)
{
  const fs::path whole = fs::absolute(path).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

bool is_name_of_kitti(const fs::path& folder)
{
  const auto name = folder.filename();
  return name == "velodyne" || name == "data" || name == "velodyne_points";
}

/** The folder of the scans, and those around it that belong to the same drive. */
std::vector<fs::path> folders_of_drive(const std::string& scans)
{
  std::vector<fs::path> folders{scans};
  for (fs::path folder = full(scans); is_name_of_kitti(folder) && folders.size() < 3;
       folder = folder.parent_path())
    folders.push_back(folder.parent_path());
  return folders;
}

void find_what_belongs_to_it(const std::string& scans, FolderLayout& layout)
{
  std::vector<fs::path> times, calibrations, poses;
  for (const auto& folder : folders_of_drive(scans))
  {
    times.insert(times.end(), {folder / "times.txt", folder / "timestamps.txt"});
    calibrations.push_back(folder / "calib.txt");
    poses.insert(poses.end(), {folder / "poses.txt", folder / "poses.tum"});
  }
  const fs::path sequence = full(folders_of_drive(scans).back());
  if (sequence.parent_path().filename() == "sequences")
    poses.push_back(
        sequence.parent_path().parent_path() / "poses" / (sequence.filename().string() + ".txt"));
  if (sequence.parent_path().filename() == "data_3d_raw")
  {
    const fs::path kitti_360 = sequence.parent_path().parent_path();
    poses.push_back(kitti_360 / "data_poses" / sequence.filename() / "poses.txt");
    layout.kitti_360 =
        fs::path(first_of({kitti_360 / "calibration" / "calib_cam_to_velo.txt"})).parent_path();
  }
  layout.times = first_of(times);
  layout.calibration = first_of(calibrations);
  layout.poses = first_of(poses);
}

std::string label_of(const std::string& scans)
{
  const fs::path folder = full(scans);
  const fs::path named = folder.filename() == "data" ? folder.parent_path() : folder;
  const std::string label = named.filename().string();
  return label.empty() ? "lidar" : label;
}

FolderLayout layout_of_folder(const std::string& path)
{
  std::error_code error;
  if (fs::directory_iterator(path, error); error)
    throw std::runtime_error(
        path + ": its files cannot be listed (" + error.message() + "). Check its permissions.");
  const std::string folder = folder_with_scans(path);
  if (folder.empty())
    throw std::runtime_error(
        path + ": holds no scans: no " + endings_of_scans() +
        " files, no bag. Name the folder with them.");
  auto scans = scans_in(folder);
  if (scans.size() != 1)
    throw std::runtime_error(
        folder + ": holds scans of several kinds, such as '" +
        fs::path(scans.begin()->second.front()).filename().string() + "' and '" +
        fs::path(scans.rbegin()->second.front()).filename().string() +
        "'. Give each kind a folder of its own.");
  FolderLayout layout;
  layout.format = scans.begin()->first;
  layout.scans = std::move(scans.begin()->second);
  sort(layout.scans);
  layout.label = label_of(folder);
  find_what_belongs_to_it(folder, layout);
  return layout;
}
}  // namespace

FolderLayout find_layout(const Input& input)
{
  const std::string& path = input.paths.front();
  if (fs::is_directory(path)) return layout_of_folder(path);
  require_readable_file(path, "scan, bag or folder of scans");
  if (!input.format)
    throw std::runtime_error(
        path + ": is no " + endings_of_scans() +
        " scan and no bag. A rawlog needs no import, nor does a simplemap: talus-map reads them.");
  FolderLayout layout;
  layout.scans = {path};
  layout.format = input.format;
  layout.label = label_of(fs::path(path).has_parent_path() ? fs::path(path).parent_path() : ".");
  return layout;
}

}  // namespace talus::import
