#include <talus/calibrate/associate.h>

#include <talus/io/quantile.h>

#include <algorithm>
#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr double kStep_m = 0.03, kLongestPause_s = 0.5, kTimeStep_s = 0.01;
constexpr double kMinHeight_m = 1e-3, kMinSlope = 1e-3;  // below: the map's own noise
constexpr int kFewPatches = 5;

/** 1.4826 times the median distance from the median: the standard deviation of a normal variable.
 */
double robust_deviation(std::vector<double> values)
{
  const double middle = io::quantile(values, 0.5);
  for (double& v : values) v = std::abs(v - middle);
  return 1.4826 * io::quantile(values, 0.5);
}
}  // namespace

std::vector<DrivenPlace> driven_places(const PoseTrack& track, double base_height_m)
{
  std::vector<DrivenPlace> places;
  Eigen::Vector3d last = Eigen::Vector3d::Constant(HUGE_VAL);
  const auto steps = static_cast<std::int64_t>((track.last_s() - track.first_s()) / kTimeStep_s);
  for (std::int64_t i = 0; i <= steps; ++i)
  {
    const double t = track.first_s() + kTimeStep_s * static_cast<double>(i);
    if (!track.covers(t))
    {
      // To the end of the gap: where a stamp is wrong it may last for years.
      const double ahead_s = std::min(track.next_s(t), track.last_s()) - track.first_s();
      i = std::max(i, static_cast<std::int64_t>(ahead_s / kTimeStep_s) - 1);
      continue;
    }
    const TrackPose pose = track.at(t);
    if (!((pose.t_m - last).norm() > kStep_m)) continue;
    last = pose.t_m;
    const Eigen::Vector3d up = pose.R.col(2);
    if (up.z() < 0.5) continue;  // no robot drives there
    places.push_back({pose.t_m - base_height_m * up, -up.head<2>() / up.z(), t});
  }
  return places;
}

std::optional<Contact> contact_in(
    const std::vector<DrivenPlace>& places, const Eigen::Vector2d& center_m, double size_m)
{
  Contact sum{Eigen::Vector2d::Zero(), 0, Eigen::Vector2d::Zero(), 0};
  int count = 0;
  for (const auto& place : places)
  {
    const Eigen::Vector2d at = place.ground_m.head<2>() - center_m;
    if (at.cwiseAbs().maxCoeff() > size_m / 2) continue;
    // A second visit would average two headings; the first pass is enough.
    if (count > 0 && place.time_s - sum.time_s / count > kLongestPause_s + size_m) break;
    sum.at_m += at;
    sum.height_m += place.ground_m.z();
    sum.slope += place.slope;
    sum.time_s += place.time_s;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Contact{sum.at_m / count, sum.height_m / count, sum.slope / count, sum.time_s / count};
}

ContactScatter scatter_of(const std::vector<Patch>& patches)
{
  std::vector<double> heights, slopes_x, slopes_y;
  for (const Patch& p : patches)
  {
    if (!p.contact) continue;
    const Contact& c = *p.contact;
    heights.push_back(p.plane[0] + c.at_m.dot(p.plane.tail<2>()) - c.height_m);
    slopes_x.push_back(p.plane[1] - c.slope.x());
    slopes_y.push_back(p.plane[2] - c.slope.y());
  }
  ContactScatter s;
  s.patches = static_cast<int>(heights.size());
  if (s.patches < kFewPatches) return s;
  s.height_m = std::max(kMinHeight_m, robust_deviation(heights));
  const double x = robust_deviation(slopes_x), y = robust_deviation(slopes_y);
  s.slope = std::max(kMinSlope, std::sqrt((x * x + y * y) / 2));
  return s;
}

}  // namespace talus::calibrate
