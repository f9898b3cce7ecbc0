#include "whole_map.h"

#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <unordered_map>

#include "folder_layout.h"
#include "formats.h"
#include "ground_levels.h"

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
constexpr double kFrame_s = 0.1;

/** The points of one tile, or those that were seen from one place. */
struct Part
{
  CPose3D T_map_sensor, T_base_sensor;
  std::vector<std::size_t> points;
};

class WholeMap : public ScanSource
{
 public:
  WholeMap(ScanFile cloud, const std::string& label, const SourceOptions& options);

  bool next(ImportedScan& scan) override;
  double progress() const override
  {
    return static_cast<double>(next_) /
           static_cast<double>(std::max<std::size_t>(parts_.size(), 1));
  }
  io::Trajectory poses() override;
  std::vector<std::string> remarks() const override { return remarks_; }
  Pieces pieces() const override
  {
    return cloud_.seen_from_m.empty() ? Pieces::Tiles : Pieces::Viewpoints;
  }

 private:
  void move_by(const CPose3D& T_map_cloud);
  void cut_by_viewpoints(GroundLevels& ground, const SourceOptions& options);
  void cut_into_tiles(GroundLevels& ground);
  std::string share_text(std::size_t points) const
  {
    return fixed_text(
               100.0 * static_cast<double>(points) / static_cast<double>(cloud_.x_m.size()), 0) +
           " %";
  }

  ScanFile cloud_;
  std::string label_;
  std::vector<Part> parts_;
  std::size_t next_ = 0;
  std::vector<std::string> remarks_;
};

WholeMap::WholeMap(ScanFile cloud, const std::string& label, const SourceOptions& options)
    : cloud_(std::move(cloud)), label_(label)
{
  const bool has_viewpoints = !cloud_.seen_from_m.empty();
  const auto* mounting = options.mounting_of(label);
  if (mounting && !has_viewpoints) move_by(*mounting);
  GroundLevels ground(cloud_);
  if (has_viewpoints)
    cut_by_viewpoints(ground, options);
  else
    cut_into_tiles(ground);
}

void WholeMap::move_by(const CPose3D& T_map_cloud)
{
  for (std::size_t i = 0; i < cloud_.x_m.size(); ++i)
    T_map_cloud.composePoint(
        cloud_.x_m[i], cloud_.y_m[i], cloud_.z_m[i], cloud_.x_m[i], cloud_.y_m[i], cloud_.z_m[i]);
}

/** A place is as large as the path of the robot during a scan. They follow each other as on a path:
 * each time the nearest one. */
void WholeMap::cut_by_viewpoints(GroundLevels& ground, const SourceOptions& options)
{
  constexpr double kPlace_m = 0.1, kFarthest_m = 1e7, kMaxHeight_m = 3;
  using Place = std::array<double, 3>;
  std::map<std::array<long, 3>, std::pair<Place, Part>> places;
  std::size_t unknown = 0;
  for (std::size_t i = 0; i < cloud_.x_m.size(); ++i)
  {
    const Place& from = cloud_.seen_from_m[i];
    std::array<long, 3> cell{};
    bool is_known = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (is_known &= std::abs(from[axis]) < kFarthest_m; is_known)
        cell[axis] = std::lround(from[axis] / kPlace_m);
    if (!is_known)
    {
      ++unknown;
      continue;
    }
    auto& [at, part] = places[cell];
    if (part.points.empty()) at = from;
    part.points.push_back(i);
  }
  const auto* given = options.mounting_of(label_);
  std::vector<std::pair<Place, Part>> left;
  left.reserve(places.size());
  for (auto& [cell, place] : places) left.push_back(std::move(place));
  for (auto& [at, part] : left) ground.reach_from(at[0], at[1], at[2]);
  for (Place last = left.empty() ? Place{} : left.front().first; !left.empty(); left.pop_back())
  {
    const auto distance = [&](const std::pair<Place, Part>& p)
    { return std::hypot(p.first[0] - last[0], p.first[1] - last[1], p.first[2] - last[2]); };
    std::swap(
        left.back(), *std::min_element(
                         left.begin(), left.end(),
                         [&](const auto& a, const auto& b) { return distance(a) < distance(b); }));
    last = left.back().first;
    Part part = std::move(left.back().second);
    part.T_map_sensor = CPose3D(last[0], last[1], last[2], 0, 0, 0);
    const auto ground_m = ground.below(last[0], last[1], last[2]);
    if (given)
      part.T_base_sensor = *given;
    else if (ground_m && last[2] - *ground_m < kMaxHeight_m)
      part.T_base_sensor = CPose3D(0, 0, last[2] - *ground_m, 0, 0, 0);
    parts_.push_back(std::move(part));
  }
  remarks_.push_back(
      "vp_x, vp_y and vp_z of the points say from where they were seen: the cloud is read as scans "
      "from " +
      std::to_string(parts_.size()) + " positions");
  if (unknown > 0)
    remarks_.push_back(share_text(unknown) + " of its points are left out: they have no viewpoint");
}

/** The rays of a tile are so steep that they prove nothing beyond the next cell. The base is the
 * sensor: where a robot has been is not known. */
void WholeMap::cut_into_tiles(GroundLevels& ground)
{
  constexpr double kTile_m = 0.5, kStripe_m = 4, kAbove_m = 2.5, kHeadroom_m = 1.8, kStorey_m = 2.5;
  if (!ground.reach_from(0, 0, 0)) ground.reach_from(0, 0, 2);
  ground.reach_rest();
  const bool has_storeys = ground.has_storeys();
  std::map<std::tuple<long, long, long, long>, std::pair<double, Part>> tiles;
  std::size_t high = 0, not_reached = 0;
  for (std::size_t i = 0; i < cloud_.x_m.size(); ++i)
  {
    const double x_m = cloud_.x_m[i], y_m = cloud_.y_m[i];
    const auto ground_m = ground.below(x_m, y_m, cloud_.z_m[i]);
    const bool is_high = ground_m && cloud_.z_m[i] - *ground_m > kHeadroom_m;
    high += is_high ? 1 : 0;
    not_reached += ground_m ? 0 : 1;
    if (!ground_m || is_high) continue;
    const auto x = std::lround(std::floor(x_m / kTile_m)),
               y = std::lround(std::floor(y_m / kTile_m));
    const auto stripe = std::lround(std::floor(y_m / kStripe_m));
    const auto storey = has_storeys ? std::lround(*ground_m / kStorey_m) : 0;
    auto& [lowest_m, part] = tiles[{storey, stripe, stripe % 2 == 0 ? x : -x, y}];
    if (part.points.empty() || *ground_m < lowest_m) lowest_m = *ground_m;
    part.T_map_sensor = CPose3D(
        kTile_m * (static_cast<double>(x) + 0.5), kTile_m * (static_cast<double>(y) + 0.5),
        lowest_m + kAbove_m, 0, 0, 0);
    part.points.push_back(i);
  }
  const std::size_t all = cloud_.x_m.size(), low = all - high - not_reached;
  if (2 * not_reached > all || 10 * low < all)
    throw std::runtime_error(
        cloud_.place +
        ": most of its points neither are ground nor stand on it. If z is not up, --mount " +
        label_ +
        "=0,0,0,YAW,PITCH,ROLL turns it; if it does not count metres, pass --scale; if it is "
        "one scan, --clouds-in sensor.");
  for (auto& [at, tile] : tiles) parts_.push_back(std::move(tile.second));
  remarks_.push_back(
      "the cloud is mapped as that of a whole drive, not as a scan (--clouds-in sensor: it is "
      "one). "
      "From where its points were seen is unknown, so no ray shows what is free: cells without "
      "points "
      "are unknown, what moved while it was recorded stands, and holes in the ground are not known "
      "from ground that was not seen. Cells twice as large as the distance of its points leave few "
      "gaps (-s resolution=0.1)");
  remarks_.push_back(
      share_text(high) + " of its points are left out, as they are more than " +
      fixed_text(kHeadroom_m, 1) + " m above ground, " + share_text(not_reached) +
      ", as no ground that connects with the rest is below them (roofs, what the robot cannot "
      "climb)");
}

bool WholeMap::next(ImportedScan& scan)
{
  if (next_ == parts_.size()) return false;
  const Part& part = parts_[next_];
  scan = {};
  scan.sensor_label = label_;
  scan.time_s = kFrame_s * static_cast<double>(next_++);
  scan.T_base_sensor = part.T_base_sensor;
  scan.T_map_sensor = part.T_map_sensor;
  for (const std::size_t i : part.points)
  {
    scan.x_m.push_back(static_cast<float>(cloud_.x_m[i] - part.T_map_sensor.x()));
    scan.y_m.push_back(static_cast<float>(cloud_.y_m[i] - part.T_map_sensor.y()));
    scan.z_m.push_back(static_cast<float>(cloud_.z_m[i] - part.T_map_sensor.z()));
    if (!cloud_.intensity.empty()) scan.intensity.push_back(cloud_.intensity[i]);
    if (!cloud_.rgb.empty()) scan.rgb.push_back(cloud_.rgb[i]);
    if (!cloud_.ring.empty()) scan.ring.push_back(cloud_.ring[i]);
  }
  scan.not_finite = next_ == 1 ? cloud_.not_finite : 0;
  return true;
}

io::Trajectory WholeMap::poses()
{
  std::vector<io::Trajectory::Entry> entries;
  for (const Part& part : parts_)
    entries.push_back(
        {kFrame_s * static_cast<double>(entries.size()),
         part.T_map_sensor + (-part.T_base_sensor)});
  return io::Trajectory(std::move(entries));
}
}  // namespace

double hidden_share(const ScanFile& cloud)
{
  constexpr double kBin = M_PI / 360, kNear_m = 0.5, kBehind = 1.3;
  std::vector<std::pair<int, double>> rays;  // direction on a cube, range [m]
  std::unordered_map<int, double> nearest_m;
  for (std::size_t i = 0; i < cloud.x_m.size(); ++i)
  {
    const std::array<double, 3> p = {cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]};
    const double range_m = std::hypot(p[0], p[1], p[2]);
    if (range_m < kNear_m) continue;
    const auto axis = static_cast<std::size_t>(
        std::max_element(
            p.begin(), p.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }) -
        p.begin());
    const auto bin_of = [&](std::size_t other)
    { return static_cast<int>(std::floor((p[other % 3] / std::abs(p[axis]) + 1) / kBin)); };
    const int face = static_cast<int>(2 * axis) + (p[axis] < 0 ? 1 : 0);
    const int bin = (1000 * face + bin_of(axis + 1)) * 1000 + bin_of(axis + 2);
    rays.emplace_back(bin, range_m);
    const auto nearest = nearest_m.emplace(bin, range_m).first;
    nearest->second = std::min(nearest->second, range_m);
  }
  const auto hidden = std::count_if(
      rays.begin(), rays.end(),
      [&](const auto& ray) { return ray.second > kBehind * nearest_m[ray.first] + kNear_m; });
  return rays.empty() ? 0 : static_cast<double>(hidden) / static_cast<double>(rays.size());
}

std::unique_ptr<ScanSource> open_whole_map(const Input& input, const SourceOptions& options)
{
  constexpr double kMany = 0.03;
  constexpr std::size_t kMinPoints = 5000;
  const auto layout = find_layout(input);
  const bool is_posed = !options.poses.empty() || !layout.poses.empty();
  const bool has_wrong_fields = !options.fields.empty() && layout.format->read != read_bin;
  if (layout.scans.size() != 1 || !layout.format->read || is_posed || has_wrong_fields ||
      options.is_one_scan || !options.is_only_source)
    return nullptr;
  ScanFile cloud;
  cloud.values = options.values;
  cloud.scale = options.scale;
  cloud.fields = options.fields;
  layout.format->read(layout.scans.front(), cloud);
  if (cloud.viewpoint && !options.clouds_in_map) return nullptr;
  // Nobody knows the place of a scanner in world coordinates, unless its mounting is given.
  const bool is_in_world =
      std::hypot(io::quantile(cloud.x_m, 0.5), io::quantile(cloud.y_m, 0.5)) > kWorld_m &&
      !options.mounting_of(layout.label);
  const bool is_map =
      options.clouds_in_map || !cloud.seen_from_m.empty() ||
      (cloud.x_m.size() >= kMinPoints && (is_in_world || hidden_share(cloud) > kMany));
  if (!is_map) return nullptr;
  return std::make_unique<WholeMap>(std::move(cloud), layout.label, options);
}

}  // namespace talus::import
