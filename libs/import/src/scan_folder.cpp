#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "folder_layout.h"
#include "formats.h"
#include "point_times.h"

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
void read_scan(const std::string& path, const Format& format, ScanFile& out)
{
  if (!out.fields.empty() && format.read != read_bin) refuse_fields(path);
  if (format.read) return format.read(path, out);
  std::string how = format.how;
  if (const auto at = how.find("{}"); at != std::string::npos) how.replace(at, 2, path);
  throw std::runtime_error(path + ": " + how);
}

/** KITTI's scanner above the road, as its page on the car says. */
const CPose3D kMountingOnKittisCar(0, 0, 1.73, 0, 0, 0);

/** Whether the times of poses are 0, 1, 2 ... of as many scans, as KISS-ICP writes them, and those
 * of the scans are others. */
bool count_scans(
    const std::vector<io::Trajectory::Entry>& poses, const std::vector<double>& times_s)
{
  if (poses.size() != times_s.size() ||
      poses.front().time_s != std::clamp(poses.front().time_s, 0.0, 1.0))
    return false;
  for (std::size_t i = 1; i < poses.size(); ++i)
    if (poses[i].time_s != poses[i - 1].time_s + 1) return false;
  return times_s.front() > poses.back().time_s + 1;
}

class ScanFolder : public ScanSource
{
 public:
  ScanFolder(const Input& input, const SourceOptions& options);

  bool next(ImportedScan& scan) override;
  double progress() const override
  {
    return static_cast<double>(next_) / static_cast<double>(layout_.scans.size());
  }
  io::Trajectory poses() override;
  std::vector<std::string> remarks() const override;

 private:
  bool is_of_kitti() const
  {
    return layout_.format->read == read_bin &&
           !(layout_.calibration.empty() && layout_.kitti_360.empty());
  }
  void set_mounting(const SourceOptions& options);
  void set_times();
  void set_poses(const SourceOptions& options);
  void set_clock();
  /** The time of the scan that was just read: a file's own where nothing beside it says one. */
  double time_of_scan(std::size_t number);
  void remark_once(bool& done, const std::string& remark)
  {
    if (!done) remarks_.push_back(remark);
    done = true;
  }
  void require_order(std::size_t number, double time_s) const;

  FolderLayout layout_;
  CPose3D T_base_sensor_;
  double rate_hz_;
  std::vector<double> times_s_;  //!< a scan each; empty: those in the files, else by the rate
  FolderPoses poses_;
  double last_s_ = 0;  //!< of what was read
  std::vector<io::Trajectory::Entry> read_poses_;  //!< one a scan, of poses_ or the viewpoints
  PointClock clock_;
  std::size_t broken_times_ = 0;  //!< points
  ScanFile file_;
  std::size_t next_ = 0;
  std::vector<std::string> remarks_;
  bool said_rate_ = false, said_times_ = false, said_counts_ = false;
};

ScanFolder::ScanFolder(const Input& input, const SourceOptions& options)
    : layout_(find_layout(input)), rate_hz_(options.rate_hz)
{
  set_mounting(options);
  file_.values = options.values;
  file_.scale = options.scale;
  file_.fields = options.fields;
  read_scan(layout_.scans.front(), *layout_.format, file_);  // what is no scan shows at once
  set_times();
  set_clock();
  if (options.own_poses) set_poses(options);
  if (!poses_.times_s.empty()) set_clock();
  const bool has_poses = !poses_.tum.empty() || !poses_.T_map_sensor.empty() || file_.viewpoint;
  if (options.clouds_in_map && !has_poses)
    throw std::runtime_error(
        input.paths.front() +
        ": --clouds-in map takes the poses of the sensor from a trajectory, and " +
        (options.own_poses ? "there is none: pass --poses FILE."
                           : "poses of KITTI's camera are those of the first folder: pass poses "
                             "as TUM text."));
}

void ScanFolder::set_mounting(const SourceOptions& options)
{
  if (const auto* mounting = options.mounting_of(layout_.label))
    T_base_sensor_ = *mounting;
  else if (is_of_kitti())
  {
    T_base_sensor_ = kMountingOnKittisCar;
    remarks_.push_back(
        layout_.label + " is taken to be 1.73 m above the road, as on KITTI's car (else: --mount " +
        layout_.label + "=X,Y,Z,YAW,PITCH,ROLL)");
  }
  else
    remarks_.push_back(
        "nothing says where " + layout_.label + " is mounted above the ground: --mount " +
        layout_.label + "=X,Y,Z,YAW,PITCH,ROLL [m, degrees]");
}

void ScanFolder::set_times()
{
  if (layout_.times.empty())
  {
    times_s_ = times_of_names(layout_.scans);
    const auto numbers = numbers_of_names(layout_.scans);
    for (std::size_t i = 0; i < times_s_.size(); ++i)
    {
      const auto name = std::filesystem::path(layout_.scans[i]).stem().string();
      const auto seconds = std::to_string(static_cast<long long>(times_s_[i]));
      if (times_s_[i] >= 1e9 && !numbers.empty() && numbers[i] == name && name.find(seconds) == 0)
        continue;
      return remarks_.push_back(
          "the names of the files are times: " + name + " is " + fixed_text(times_s_[i], 3) + " s");
    }
    return;
  }
  const auto times_s = read_times(layout_.times);
  const auto lines = lines_of_scans(layout_.scans, times_s.size(), layout_.times);
  times_s_.reserve(lines.size());
  for (const std::size_t line : lines) times_s_.push_back(times_s[line]);
}

void ScanFolder::set_poses(const SourceOptions& options)
{
  const std::string path = options.poses.empty() ? layout_.poses : options.poses;
  if (path.empty()) return;
  if (options.poses.empty()) remarks_.push_back("the poses are those of " + path);
  poses_ = read_folder_poses(path, layout_, options, !times_s_.empty() || clock_.is_since_epoch());
  const auto count = layout_.scans.size();
  if (poses_.scans == count) return;
  layout_.scans.resize(poses_.scans);
  if (layout_.scans.empty()) throw std::runtime_error(path + ": has no poses.");
  remarks_.push_back(
      "the last " + std::to_string(count - poses_.scans) + " of " + std::to_string(count) +
      " scans of " + layout_.label + " are left out: " + path + " has no poses for them");
}

/** Of scans from the whole folder. */
void ScanFolder::set_clock()
{
  constexpr std::size_t kEnough = 9;
  if (file_.time.empty()) return;
  const auto& times_s = times_s_.empty() ? poses_.times_s : times_s_;
  clock_ = {};
  ScanFile scan = file_;
  std::size_t last = 0;
  for (std::size_t i = 0; i < std::min(kEnough, layout_.scans.size()); ++i)
  {
    const std::size_t number = i * layout_.scans.size() / std::min(kEnough, layout_.scans.size());
    if (number != last) read_scan(layout_.scans[number], *layout_.format, scan);
    last = number;
    clock_.add(scan, number < times_s.size() ? times_s[number] : std::nan(""));
  }
  std::vector<double> periods_s;
  for (std::size_t i = 1; i < times_s.size(); ++i) periods_s.push_back(times_s[i] - times_s[i - 1]);
  if (!periods_s.empty()) clock_.set_period(io::quantile(std::move(periods_s), 0.5));
}

double ScanFolder::time_of_scan(std::size_t number)
{
  if (!times_s_.empty()) return times_s_[number];
  if (const double first_s = clock_.first_s(file_); clock_.is_since_epoch() && !std::isnan(first_s))
    return first_s;
  if (!poses_.times_s.empty())
  {
    remark_once(
        said_rate_, "nothing says when the scans of " + layout_.label +
                        " were taken: one at each of the poses, of which there are as many");
    return poses_.times_s[number];
  }
  remark_once(
      said_rate_, "nothing says when the scans of " + layout_.label +
                      " were taken: " + number_text(rate_hz_) + " a second (--rate)");
  return static_cast<double>(number) / rate_hz_;
}

void ScanFolder::require_order(std::size_t number, double time_s) const
{
  if (number == 0 || time_s > last_s_) return;
  throw std::runtime_error(
      layout_.scans[number] + ": its points are no later than those of " +
      layout_.scans[number - 1] + ", though its name is. Rename the files into the order of time.");
}

bool ScanFolder::next(ImportedScan& scan)
{
  if (next_ == layout_.scans.size()) return false;
  const std::size_t number = next_;
  if (number > 0) read_scan(layout_.scans[number], *layout_.format, file_);
  const bool has_times = !file_.time.empty();
  if (has_times && clock_.empty())
    clock_.add(file_, times_s_.empty() ? std::nan("") : times_s_[number]);
  broken_times_ += clock_.leave_out_broken(file_);
  const double time_s = time_of_scan(number);
  require_order(number, time_s);
  ++next_;

  scan.sensor_label = layout_.label;
  scan.time_s = time_s;
  scan.T_base_sensor = T_base_sensor_;
  scan.point_time_s = clock_.times_since(time_s, file_);
  take_points(file_, scan);
  if (scan.point_time_s.empty() && has_times && clock_.is_understood())
    remark_once(
        said_times_,
        "the times of the points are left out: they lie more than a minute from those "
        "of the scans, first in " +
            layout_.scans[number]);
  last_s_ = time_s;
  scan.T_map_sensor = poses_.T_map_sensor.empty() ? file_.viewpoint : poses_.T_map_sensor[number];
  if (!poses_.tum.empty()) scan.T_map_sensor.reset();
  if (scan.T_map_sensor) read_poses_.push_back({time_s, *scan.T_map_sensor + (-T_base_sensor_)});
  return true;
}

std::vector<std::string> ScanFolder::remarks() const
{
  auto all = remarks_;
  if (const auto said = clock_.remark(); !said.empty()) all.push_back(layout_.label + ": " + said);
  if (broken_times_ > 0)
    all.push_back(
        layout_.label + ": " + std::to_string(broken_times_) +
        " points are left out: their times are far from those of their scans");
  return all;
}

io::Trajectory ScanFolder::poses()
{
  if (poses_.tum.empty()) return io::Trajectory(read_poses_);
  auto entries = io::Trajectory::load(poses_.tum).entries();
  if (!count_scans(entries, times_s_)) return io::Trajectory(std::move(entries));
  for (std::size_t i = 0; i < entries.size(); ++i) entries[i].time_s = times_s_[i];
  remark_once(
      said_counts_, "the times of the poses in " + poses_.tum + " count the scans: one for each");
  return io::Trajectory(std::move(entries));
}
}  // namespace

std::unique_ptr<ScanSource> open_scan_folder(const Input& input, const SourceOptions& options)
{
  return std::make_unique<ScanFolder>(input, options);
}

}  // namespace talus::import
