#include "folder_layout.h"

#include <talus/import/kitti_poses.h>
#include <talus/io/trajectory.h>
#include <talus/number_text.h>

#include <algorithm>
#include <map>
#include <stdexcept>

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
constexpr const char* kTimes = "a times.txt (seconds, a line a scan) in the folder of the scans";

std::string counts(std::size_t poses, std::size_t scans)
{
  return "has " + std::to_string(poses) + " poses for " + std::to_string(scans) + " scans";
}

[[noreturn]] void fail(const std::string& path, const std::string& what)
{
  throw std::runtime_error(path + ": " + what + ".");
}

/** Poses over time that are others than those of scans at a rate from 0 on. */
bool are_elsewhere(const std::vector<io::Trajectory::Entry>& poses, double last_s)
{
  constexpr double kNear_s = 1;
  return poses.empty() || poses.front().time_s > last_s + kNear_s || poses.back().time_s < -kNear_s;
}

FolderPoses read_trajectory(
    const std::string& path, std::size_t scans, const SourceOptions& options, bool have_times)
{
  FolderPoses poses;
  poses.tum = path;
  poses.scans = scans;
  if (have_times) return poses;
  const auto entries = io::Trajectory::load(path).entries();
  const bool is_partial = options.partial && entries.size() < scans;
  if (entries.size() == scans || is_partial)
  {
    for (const auto& entry : entries) poses.times_s.push_back(entry.time_s);
    poses.scans = entries.size();
  }
  else if (are_elsewhere(entries, static_cast<double>(scans) / options.rate_hz))
    fail(
        path, counts(entries.size(), scans) + ", and nothing says when these were taken. Put " +
                  kTimes +
                  (entries.size() < scans
                       ? "; or let --partial read the first " + std::to_string(entries.size()) +
                             " scans, one at each of the poses"
                       : ""));
  return poses;
}

/** Turns a pose of the file into that of the scanner. */
class ToScanner
{
 public:
  ToScanner(
      const std::string& path, const KittiPoses& rows, const FolderLayout& layout,
      const SourceOptions& options)
  {
    if (options.poses_of_sensor) return;
    if (!rows.frames.empty() && !layout.kitti_360.empty())
      T_posed_scanner_ = read_kitti_360_calibration(layout.kitti_360);
    else if (!layout.calibration.empty())
    {
      T_posed_scanner_ = read_kitti_calibration(layout.calibration);
      T_map_first_ = -T_posed_scanner_;
    }
    else
      fail(
          path, "has poses of KITTI's " + std::string(rows.frames.empty() ? "camera" : "car") +
                    ", or of the scanner itself. For the scanner's pass --poses-of sensor; else "
                    "calib.txt with its line 'Tr:' belongs beside the scans in " +
                    layout.label +
                    (rows.frames.empty() ? std::string()
                                         : ", or KITTI-360's folder calibration beside its folder "
                                           "data_3d_raw"));
  }
  CPose3D operator()(const CPose3D& pose) const { return T_map_first_ + pose + T_posed_scanner_; }

 private:
  CPose3D T_map_first_, T_posed_scanner_;
};

FolderPoses read_frames(
    const std::string& path, const KittiPoses& rows, const std::vector<std::string>& scans,
    const ToScanner& to_scanner)
{
  std::map<std::size_t, std::size_t> row_of;
  for (std::size_t i = 0; i < rows.frames.size(); ++i) row_of[rows.frames[i]] = i;
  FolderPoses poses;
  poses.scans = scans.size();
  bool any = false;
  for (const auto& scan : scans)
  {
    const auto number = number_of_scan(scan);
    const auto row = number ? row_of.find(*number) : row_of.end();
    poses.T_map_sensor.emplace_back();
    if (row == row_of.end()) continue;
    poses.T_map_sensor.back() = to_scanner(rows.poses[row->second]);
    any = true;
  }
  if (!any)
    fail(
        path, "has poses of frames " + std::to_string(rows.frames.front()) + " to " +
                  std::to_string(rows.frames.back()) +
                  ", of which no scan is there: their names are the numbers of frames");
  return poses;
}

FolderPoses read_rows(
    const std::string& path, const KittiPoses& rows, const FolderLayout& layout,
    const SourceOptions& options, const ToScanner& to_scanner)
{
  const auto count = rows.poses.size();
  auto scans = layout.scans;
  if (count < scans.size() && options.partial)
    scans.resize(count);
  else if (count < scans.size() && !have_lines_by_number(scans, count))
    fail(
        path, counts(count, scans.size()) +
                  ". Give it a line a scan; or let --partial read the "
                  "first " +
                  std::to_string(count) + " scans, one at each of the poses");
  FolderPoses poses;
  poses.scans = scans.size();
  for (const std::size_t line : lines_of_scans(scans, count, path))
    poses.T_map_sensor.emplace_back(to_scanner(rows.poses[line]));
  return poses;
}
}  // namespace

FolderPoses read_folder_poses(
    const std::string& path, const FolderLayout& layout, const SourceOptions& options,
    bool have_times)
{
  if (!is_kitti_poses(path)) return read_trajectory(path, layout.scans.size(), options, have_times);
  const auto rows = read_kitti_poses(path);
  const ToScanner to_scanner(path, rows, layout, options);
  if (!rows.frames.empty()) return read_frames(path, rows, layout.scans, to_scanner);
  return read_rows(path, rows, layout, options, to_scanner);
}

}  // namespace talus::import
