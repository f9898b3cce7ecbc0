#include "placed_scans.h"

#include <talus/import/kitti_poses.h>
#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
constexpr const char* kClouds_in_map = "pass --clouds-in map";

std::array<double, 3> place_of(const CPose3D& T) { return {T.x(), T.y(), T.z()}; }

std::string text_of(const CPose3D& T)
{
  return number_text(T.x(), 12) + ", " + number_text(T.y(), 12) + ", " + number_text(T.z(), 12);
}

/** Of scans far from the origin of the map: whether their points lie around it, or around the
 * sensor. In the frame of the sensor they do the one, in that of the map the other. */
class FrameVotes
{
 public:
  void look_at(const ImportedScan& scan, const CPose3D& T_map_sensor)
  {
    constexpr double kClearly = 0.5;
    const auto sensor_m = place_of(T_map_sensor);
    if (is_left_behind(T_map_sensor, scan.T_base_sensor)) return vote(true, false);
    if (T_map_sensor.norm() < kFar_m || scan.x_m.empty()) return;
    const double from_origin_m = median_range_m(scan, {}),
                 from_sensor_m = median_range_m(scan, sensor_m);
    vote(from_sensor_m < kClearly * from_origin_m, from_origin_m < kClearly * from_sensor_m);
  }
  bool are_in_map() const { return is_most(in_map_); }
  bool are_in_sensor() const { return is_most(in_sensor_); }

 private:
  static constexpr double kFar_m = 10;
  /** TF has clouds in the map mounted at the origin of the map, wherever the base is. */
  static bool is_left_behind(const CPose3D& T_map_sensor, const CPose3D& T_base_sensor)
  {
    constexpr double kSame_m = 1e-3;
    return T_map_sensor.norm() < kSame_m && T_base_sensor.norm() >= kFar_m;
  }
  void vote(bool in_map, bool in_sensor)
  {
    ++all_;
    in_map_ += in_map ? 1 : 0;
    in_sensor_ += in_sensor ? 1 : 0;
  }
  bool is_most(std::size_t votes) const
  {
    constexpr std::size_t kMinCount = 3;
    return all_ >= kMinCount && 5 * votes >= 4 * all_;
  }
  std::size_t all_ = 0, in_map_ = 0, in_sensor_ = 0;
};

class PlacedScans : public ScanSource
{
 public:
  PlacedScans(
      std::unique_ptr<ScanSource> source, const std::string& path, const SourceOptions& options,
      bool mounted_by_tf);

  bool next(ImportedScan& scan) override;
  double progress() const override { return source_->progress(); }
  io::Trajectory poses() override;
  std::vector<std::string> remarks() const override;
  std::vector<std::string> warnings() const override { return source_->warnings(); }
  bool wants(SourceOptions& options) const override { return source_->wants(options); }

 private:
  /** False: it is left out. */
  bool place(ImportedScan& scan);
  void place_in_world(ImportedScan& scan);
  void bring_from_map(ImportedScan& scan, const CPose3D& T_map_sensor);
  std::optional<CPose3D> T_map_sensor_of(const ImportedScan& scan) const;
  CPose3D T_map_base_of(const CPose3D& pose) const
  {
    return options_.poses_of_sensor ? pose + T_sensor_base_ : pose;
  }
  bool has_poses() const { return has_own_ || !trajectory_.empty(); }
  void require_placed() const;
  /** Of a bag TF only has how the map is mounted, in which the points are. */
  void require_mounting(const ImportedScan& scan) const
  {
    if (mounted_by_tf_ && !options_.mounting_of(scan.sensor_label))
      fail(
          "--clouds-in map needs the place of the sensor on the base: --mount " +
          scan.sensor_label + "=X,Y,Z,YAW,PITCH,ROLL");
  }
  [[noreturn]] void fail(const std::string& what) const
  {
    throw std::runtime_error(path_ + ": " + what + ".");
  }

  std::unique_ptr<ScanSource> source_;
  std::string path_;
  SourceOptions options_;
  io::Trajectory trajectory_;  //!< poses that are there from the beginning
  bool mounted_by_tf_;
  bool has_own_ = false;  //!< scans bring poses of their own
  CPose3D T_sensor_base_;  //!< of the first scan
  std::string first_label_;
  bool several_ = false;  //!< sensors
  std::optional<io::Trajectory::Entry> made_;  //!< of the only scan, in world coordinates
  std::size_t scans_ = 0, posed_ = 0, timed_ = 0;
  FrameVotes votes_;
  GroundCheck ground_;
};

PlacedScans::PlacedScans(
    std::unique_ptr<ScanSource> source, const std::string& path, const SourceOptions& options,
    bool mounted_by_tf)
    : source_(std::move(source)), path_(path), options_(options), mounted_by_tf_(mounted_by_tf)
{
  const bool is_given = mounted_by_tf && !options.poses.empty() && !is_kitti_poses(options.poses);
  trajectory_ = is_given ? io::Trajectory::load(options.poses) : source_->poses();
}

bool PlacedScans::next(ImportedScan& scan)
{
  for (;;)
  {
    scan.T_map_sensor.reset();
    if (!source_->next(scan)) return require_placed(), false;
    if (scans_++ == 0)
    {
      first_label_ = scan.sensor_label;
      T_sensor_base_ = -scan.T_base_sensor;
    }
    several_ = several_ || scan.sensor_label != first_label_;
    if (!place(scan)) continue;
    ground_.look_at(scan);
    return true;
  }
}

std::optional<CPose3D> PlacedScans::T_map_sensor_of(const ImportedScan& scan) const
{
  constexpr double kMaxGap_s = 0.5;  // as talus-map has it
  if (scan.T_map_sensor) return scan.T_map_sensor;
  if (trajectory_.empty()) return std::nullopt;
  const auto pose = trajectory_.at(scan.time_s, kMaxGap_s);
  if (!pose) return std::nullopt;
  return T_map_base_of(*pose) + scan.T_base_sensor;
}

bool PlacedScans::place(ImportedScan& scan)
{
  has_own_ = has_own_ || scan.T_map_sensor;
  const auto T_map_sensor = T_map_sensor_of(scan);
  if (T_map_sensor) votes_.look_at(scan, *T_map_sensor);
  posed_ += T_map_sensor ? 1 : 0;
  if (options_.clouds_in_map)
  {
    require_mounting(scan);
    if (!T_map_sensor) return false;
    bring_from_map(scan, *T_map_sensor);
  }
  else if (is_in_world(scan) || made_)
    place_in_world(scan);
  return true;
}

void PlacedScans::bring_from_map(ImportedScan& scan, const CPose3D& T_map_sensor)
{
  constexpr double kFarthest_m = 1000;
  const double range_m = median_range_m(scan, place_of(T_map_sensor));
  if (range_m > kFarthest_m)
    fail(
        "its points lie " + number_text(std::round(range_m)) + " m from where the poses have the " +
        "sensor at " + number_text(scan.time_s, 16) +
        " s: clouds and poses are not in the same frame");
  bring_to_sensor(T_map_sensor, scan);
  timed_ += scan.point_time_s.empty() ? 0 : 1;
  scan.point_time_s.clear();  // each point is where it was at its time
}

void PlacedScans::place_in_world(ImportedScan& scan)
{
  const auto& at_m = scan.origin_m;
  const std::string what =
      "its points lie " + number_text(std::round(std::hypot(at_m[0], at_m[1], at_m[2]) / 1000)) +
      " km from their origin: they are in world coordinates, not in the frame of the sensor";
  if (has_poses()) fail(what + ". If the poses are in the same ones, " + kClouds_in_map);
  if (made_ || !options_.is_only_source)
    fail(what + ". For several scans " + kClouds_in_map + " with --poses FILE");
  made_ = io::Trajectory::Entry{scan.time_s, base_below(scan)};
  bring_from_map(scan, made_->T_map_base + scan.T_base_sensor);
}

void PlacedScans::require_placed() const
{
  if (!options_.clouds_in_map || scans_ == 0 || posed_ > 0) return;
  fail(
      "--clouds-in map takes the poses of the sensor from a trajectory, and it has none at the "
      "times of the scans: pass --poses FILE with the clock of the scans");
}

io::Trajectory PlacedScans::poses()
{
  if (made_) return io::Trajectory({*made_});
  if (has_own_) return source_->poses();
  auto entries = trajectory_.entries();
  for (auto& entry : entries) entry.T_map_base = T_map_base_of(entry.T_map_base);
  return io::Trajectory(std::move(entries));
}

std::vector<std::string> PlacedScans::remarks() const
{
  auto all = source_->remarks();
  const auto count = [this](std::size_t scans)
  { return std::to_string(scans) + " of " + std::to_string(scans_) + " scans "; };
  if (made_)
    all.push_back(
        "the points are in world coordinates: " + text_of(made_->T_map_base) +
        " m is taken off them in double precision and kept as the pose of the base, so that maps "
        "have these coordinates; what rays pass through is seen from there");
  if (options_.poses_of_sensor && several_)
    all.push_back("the poses are taken to be those of " + first_label_);
  if (timed_ > 0)
    all.push_back(count(timed_) + "lose the times of their points, which lie where they were seen");
  if (has_poses() && posed_ < scans_)
    all.push_back(
        count(scans_ - posed_) + "have no pose at their time" +
        (options_.clouds_in_map ? ", and are left out" : ": talus-map skips them"));
  if (!options_.clouds_in_map && votes_.are_in_map())
    all.push_back(
        std::string("the points lie around the poses of the sensor, as those in the frame of the "
                    "map do, not around the sensor: if they are, ") +
        kClouds_in_map);
  if (options_.clouds_in_map && votes_.are_in_sensor())
    all.push_back(
        "the points lie around the origin wherever the sensor is, as those in the frame of the "
        "sensor do: if they are, leave out --clouds-in map");
  for (auto& remark : ground_.remarks()) all.push_back(std::move(remark));
  return all;
}
}  // namespace

std::unique_ptr<ScanSource> place_scans(
    std::unique_ptr<ScanSource> source, const std::string& path, const SourceOptions& options,
    bool mounted_by_tf)
{
  return std::make_unique<PlacedScans>(std::move(source), path, options, mounted_by_tf);
}

bool is_in_world(const ImportedScan& scan) { return scan.origin_m != std::array<double, 3>{}; }

void bring_to_sensor(const CPose3D& T_map_sensor, ImportedScan& scan)
{
  const auto& R = T_map_sensor.getRotationMatrix();
  const std::array<double, 3> shift_m = {
      scan.origin_m[0] - T_map_sensor.x(), scan.origin_m[1] - T_map_sensor.y(),
      scan.origin_m[2] - T_map_sensor.z()};
  for (std::size_t i = 0; i < scan.x_m.size(); ++i)
  {
    const double x = scan.x_m[i] + shift_m[0], y = scan.y_m[i] + shift_m[1],
                 z = scan.z_m[i] + shift_m[2];
    scan.x_m[i] = static_cast<float>(R(0, 0) * x + R(1, 0) * y + R(2, 0) * z);
    scan.y_m[i] = static_cast<float>(R(0, 1) * x + R(1, 1) * y + R(2, 1) * z);
    scan.z_m[i] = static_cast<float>(R(0, 2) * x + R(1, 2) * y + R(2, 2) * z);
  }
  scan.origin_m = {};
}

CPose3D base_below(const ImportedScan& scan)
{
  constexpr double kAround_m = 5, kLow = 0.05;
  constexpr std::size_t kMinCount = 20;
  std::vector<double> near_m, all_m;
  for (std::size_t i = 0; i < scan.x_m.size(); ++i)
  {
    all_m.push_back(scan.z_m[i]);
    if (std::hypot(scan.x_m[i], scan.y_m[i]) < kAround_m) near_m.push_back(scan.z_m[i]);
  }
  auto& heights_m = near_m.size() < kMinCount ? all_m : near_m;
  const double low_m = scan.origin_m[2] + io::quantile(heights_m, kLow);
  const double ground_m = std::round(100 * low_m) / 100;
  return {scan.origin_m[0], scan.origin_m[1], ground_m, 0, 0, 0};
}

double median_range_m(const ImportedScan& scan, const std::array<double, 3>& from_m)
{
  constexpr std::size_t kEnough = 2000;
  const std::size_t step = scan.x_m.size() / kEnough + 1;
  std::vector<double> ranges_m;
  ranges_m.reserve(kEnough + 1);
  for (std::size_t i = 0; i < scan.x_m.size(); i += step)
    ranges_m.push_back(std::hypot(
        scan.x_m[i] + (scan.origin_m[0] - from_m[0]), scan.y_m[i] + (scan.origin_m[1] - from_m[1]),
        scan.z_m[i] + (scan.origin_m[2] - from_m[2])));
  return ranges_m.empty() ? 0 : io::quantile(std::move(ranges_m), 0.5);
}

}  // namespace talus::import
