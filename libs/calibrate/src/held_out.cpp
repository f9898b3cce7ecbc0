#include <talus/calibrate/held_out.h>

#include <talus/io/quantile.h>

#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace talus::calibrate
{
namespace
{
constexpr double kCell_m = 0.4;
constexpr double kScale_m = 0.08;  // of ground that is badly calibrated
constexpr double kReach_m = 0.5;  // beyond it from the ground a point shows something else
constexpr double kBin_m = 2;
constexpr std::size_t kFewPointsOfBin = 30;

using Cells = std::map<std::pair<long, long>, const Patch*>;

std::pair<long, long> cell_of(const Eigen::Vector3d& p)
{
  return {std::lround(std::floor(p.x() / kCell_m)), std::lround(std::floor(p.y() / kCell_m))};
}

/** The ground as one estimate maps it. */
class GroundMap
{
 public:
  GroundMap(const ScanSet& scans, const PoseTrack& track, const Vector& v) : v_(v)
  {
    AssociationOptions options;
    options.cell_m = options.least_cell_m = kCell_m;
    options.max_range_m = scans.thinning().max_range_m;
    options.inlier_share = 0.5;
    options.most_samples = std::numeric_limits<std::size_t>::max();
    options.most_per_patch = 1;  // only the planes are used
    association_ = associate(scans, track, {}, v, uniform_noise(kScale_m), options);
    for (const Patch& p : association_.patches)
      cells_[cell_of({p.center_m.x(), p.center_m.y(), 0})] = &p;
    evaluate_geometry(scans, track, v, geometry_);
  }

  /** Signed distance from the ground, NaN where there is none. */
  double distance_m(std::uint32_t view, const Eigen::Vector3d& p_sensor) const
  {
    const TrackPose& pose = geometry_.views[view];
    const Eigen::Vector3d p =
        pose.R * (geometry_.mounting.R * p_sensor + geometry_.mounting.t_m) + pose.t_m;
    const auto found = cells_.find(cell_of(p));
    if (found == cells_.end()) return std::numeric_limits<double>::quiet_NaN();
    const Patch& patch = *found->second;
    return point_to_plane(geometry_, view, p_sensor, patch.center_m, patch.plane).distance_m;
  }
  double time_offset_s() const { return v_[kTimeOffset]; }

 private:
  Vector v_;
  Association association_;
  Cells cells_;
  Geometry geometry_;
};

struct Distance
{
  double range_m, distance_m;
};

double thickness(std::vector<double> absolute)
{
  return 1.4826 * io::quantile(std::move(absolute), 0.5);
}

RangeBin bin_of(const std::vector<Distance>& all, double from_m)
{
  RangeBin bin{from_m, from_m + kBin_m, 0, 0, 0};
  std::vector<double> values;
  for (const auto& d : all)
    if (d.range_m >= bin.from_m && d.range_m < bin.to_m) values.push_back(d.distance_m);
  bin.points = values.size();
  if (bin.points < kFewPointsOfBin) return bin;
  bin.offset_m = io::quantile(values, 0.5);
  for (double& v : values) v = std::abs(v);
  bin.thickness_m = thickness(std::move(values));
  return bin;
}

HeldOutFigures figures_of(const std::vector<Distance>& all, double max_range_m)
{
  HeldOutFigures f;
  f.points = all.size();
  if (all.empty()) return f;
  std::vector<double> absolute;
  absolute.reserve(all.size());
  for (const auto& d : all) absolute.push_back(std::abs(d.distance_m));
  f.thickness_m = thickness(absolute);
  f.p95_m = io::quantile(std::move(absolute), 0.95);
  for (double from_m = 0; from_m < max_range_m; from_m += kBin_m)
    if (auto bin = bin_of(all, from_m); bin.points >= kFewPointsOfBin) f.by_range.push_back(bin);
  return f;
}
}  // namespace

BeforeAfter held_out_figures(
    const ScanSet& scans, const PoseTrack& track, const Vector& before, const Vector& after)
{
  const GroundMap map_before(scans, track, before), map_after(scans, track, after);
  std::vector<Distance> distances_before, distances_after;
  for (std::uint32_t i = 0; i < scans.views().size(); ++i)
  {
    const View& view = scans.views()[i];
    if (!scans.held_out(view.frame)) continue;
    if (!track.covers(view.time_s + before[kTimeOffset]) ||
        !track.covers(view.time_s + after[kTimeOffset]))
      continue;
    for (std::uint32_t k = view.first; k < view.first + view.count; ++k)
    {
      const Eigen::Vector3d p = scans.point(k);
      const double b = map_before.distance_m(i, p), a = map_after.distance_m(i, p);
      if (!(std::abs(b) < kReach_m && std::abs(a) < kReach_m)) continue;
      distances_before.push_back({p.norm(), b});
      distances_after.push_back({p.norm(), a});
    }
  }
  const double far_m = scans.thinning().max_range_m;
  return {figures_of(distances_before, far_m), figures_of(distances_after, far_m)};
}

}  // namespace talus::calibrate
