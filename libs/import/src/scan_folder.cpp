#include "scan_folder.h"

#include <talus/import/kitti_poses.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>

#include "folder_layout.h"
#include "scan_files.h"
#include "scan_times.h"

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
using io::ForeignScans;

void read_scan(const std::string& path, ForeignScans kind, ScanFile& out)
{
  switch (kind)
  {
    case ForeignScans::Bin:
      return read_kitti_bin(path, out);
    case ForeignScans::Pcd:
      return read_pcd(path, out);
    case ForeignScans::Ply:
      return read_ply(path, out);
    default:
      throw std::runtime_error(path + ": " + io::how_to_import(path, kind));
  }
}

/** KITTI's scanner above the road, as its page on the car says. */
const CPose3D kMountingOnKittisCar(0, 0, 1.73, 0, 0, 0);

class ScanFolder : public ScanSource
{
 public:
  ScanFolder(const std::string& path, const SourceOptions& options);

  bool next(ImportedScan& scan) override;
  double progress() const override
  {
    return static_cast<double>(next_) / static_cast<double>(layout_.scans.size());
  }
  io::Trajectory poses() override;
  std::vector<std::string> remarks() const override { return remarks_; }

 private:
  bool is_of_kitti() const
  {
    return layout_.kind == ForeignScans::Bin && !layout_.calibration.empty();
  }
  void set_mounting(const SourceOptions& options);
  void set_times();
  void set_poses(const std::string& given);
  /** The time of the scan that was just read: a file's own where nothing beside it says one. */
  double time_of_scan(std::size_t number, double unit_s);
  void tell_once(bool& told, const std::string& remark)
  {
    if (!told) remarks_.push_back(remark);
    told = true;
  }
  void require_order(std::size_t number, double time_s) const;

  FolderLayout layout_;
  CPose3D T_base_sensor_;
  double rate_hz_;
  std::vector<double> times_s_;  //!< a scan each; empty: those in the files, else by the rate
  std::string tum_;  //!< poses of the base
  std::vector<double> pose_times_s_;  //!< of those in tum_, where there is one a scan
  std::vector<CPose3D> T_map_sensor_;  //!< a scan each; empty: the viewpoints in the files
  std::vector<double> read_times_s_;  //!< of what was read
  std::vector<io::Trajectory::Entry> viewpoints_;
  std::optional<double> unit_s_;  //!< of the times of points, as the first scan has it
  ScanFile file_;
  std::size_t next_ = 0;
  std::vector<std::string> remarks_;
  bool told_rate_ = false, told_times_ = false;
};

ScanFolder::ScanFolder(const std::string& path, const SourceOptions& options)
    : layout_(find_layout(path)), rate_hz_(options.rate_hz)
{
  set_mounting(options);
  read_scan(layout_.scans.front(), layout_.kind, file_);  // what is no scan shows at once
  set_times();
  if (options.own_poses) set_poses(options.poses);
}

void ScanFolder::set_mounting(const SourceOptions& options)
{
  const auto mounting = options.mountings.find(layout_.label);
  if (mounting != options.mountings.end())
    T_base_sensor_ = mounting->second;
  else if (is_of_kitti())
  {
    T_base_sensor_ = kMountingOnKittisCar;
    remarks_.push_back(
        layout_.label + " is taken to be 1.73 m above the road, as on KITTI's car (else: --mount " +
        layout_.label + "=x,y,z,yaw,pitch,roll)");
  }
  else
    remarks_.push_back(
        "nothing says where " + layout_.label + " is mounted above the ground: --mount " +
        layout_.label + "=x,y,z,yaw,pitch,roll [m, degrees]");
}

void ScanFolder::set_times()
{
  if (layout_.times.empty())
  {
    times_s_ = times_of_names(layout_.scans);
    return;
  }
  const auto times_s = read_times(layout_.times);
  const auto lines = lines_of_scans(layout_.scans, times_s.size(), layout_.times);
  times_s_.reserve(lines.size());
  for (const std::size_t line : lines) times_s_.push_back(times_s[line]);
}

void ScanFolder::set_poses(const std::string& given)
{
  const std::string path = given.empty() ? layout_.poses : given;
  if (path.empty()) return;
  if (given.empty()) remarks_.push_back("the poses are those of " + path);
  if (!is_kitti_poses(path))
  {
    tum_ = path;
    const auto entries = io::Trajectory::load(path).entries();
    if (entries.size() != layout_.scans.size()) return;
    pose_times_s_.reserve(entries.size());
    for (const auto& entry : entries) pose_times_s_.push_back(entry.time_s);
    return;
  }
  if (layout_.calibration.empty())
    throw std::runtime_error(
        path +
        ": has poses of KITTI's camera; to turn them into those of the scanner, calib.txt "
        "with its line 'Tr:' belongs beside the scans in " +
        layout_.label +
        ". Copy it there (poses of the scanner itself: Tr: 1 0 0 0 0 1 0 0 0 0 1 0).");
  const auto T_camera_scanner = read_kitti_calibration(layout_.calibration);
  const auto poses = read_kitti_poses(path);
  const auto lines = lines_of_scans(layout_.scans, poses.size(), path);
  T_map_sensor_.reserve(lines.size());
  for (const std::size_t line : lines)
    T_map_sensor_.push_back((-T_camera_scanner) + poses[line] + T_camera_scanner);
}

double ScanFolder::time_of_scan(std::size_t number, double unit_s)
{
  if (!times_s_.empty()) return times_s_[number];
  constexpr double kSinceEpoch_s = 1e9;
  if (!file_.time.empty())
    if (const double first_s = unit_s * *std::min_element(file_.time.begin(), file_.time.end());
        first_s >= kSinceEpoch_s)
      return first_s;
  if (!pose_times_s_.empty())
  {
    tell_once(
        told_rate_, "nothing says when the scans of " + layout_.label +
                        " were taken: one at each of the poses, of which there are as many");
    return pose_times_s_[number];
  }
  tell_once(
      told_rate_, "nothing says when the scans of " + layout_.label +
                      " were taken: " + number_text(rate_hz_) + " a second (--rate)");
  return static_cast<double>(number) / rate_hz_;
}

void ScanFolder::require_order(std::size_t number, double time_s) const
{
  if (number == 0 || time_s > read_times_s_.back()) return;
  throw std::runtime_error(
      layout_.scans[number] + ": its points are no later than those of " +
      layout_.scans[number - 1] + ", though its name is. Rename the files into the order of time.");
}

bool ScanFolder::next(ImportedScan& scan)
{
  if (next_ == layout_.scans.size()) return false;
  const std::size_t number = next_;
  if (number > 0) read_scan(layout_.scans[number], layout_.kind, file_);
  if (!unit_s_ && !file_.time.empty()) unit_s_ = time_unit_s(file_);
  const double unit_s = unit_s_.value_or(1);
  const double time_s = time_of_scan(number, unit_s);
  require_order(number, time_s);
  ++next_;

  scan.sensor_label = layout_.label;
  scan.time_s = time_s;
  scan.T_base_sensor = T_base_sensor_;
  take_points(file_, scan);
  scan.point_time_s = times_since(time_s, file_, unit_s);
  if (scan.point_time_s.empty() && !file_.time.empty())
    tell_once(
        told_times_,
        "the times of the points are left out: they lie more than a minute from those "
        "of the scans, first in " +
            layout_.scans[number]);
  read_times_s_.push_back(time_s);
  if (file_.viewpoint) viewpoints_.push_back({time_s, *file_.viewpoint + (-T_base_sensor_)});
  return true;
}

io::Trajectory ScanFolder::poses()
{
  if (!tum_.empty()) return io::Trajectory::load(tum_);
  if (T_map_sensor_.empty()) return io::Trajectory(viewpoints_);
  std::vector<io::Trajectory::Entry> entries;
  entries.reserve(read_times_s_.size());
  for (std::size_t i = 0; i < read_times_s_.size(); ++i)
    entries.push_back({read_times_s_[i], T_map_sensor_[i] + (-T_base_sensor_)});
  return io::Trajectory(entries);
}
}  // namespace

std::unique_ptr<ScanSource> open_scan_folder(const std::string& path, const SourceOptions& options)
{
  return std::make_unique<ScanFolder>(path, options);
}

}  // namespace talus::import
