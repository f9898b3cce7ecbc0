#include <talus/sim/drop_reach.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace talus::sim
{
namespace
{
/** A ray straight ahead that meets level ground. */
struct DownRay
{
  double ground_m;  //!< from the base
  double slope;  //!< how much deeper it comes with each metre
};

std::vector<DownRay> down_rays(const Scanner& scanner, const Pose& T_base_sensor)
{
  std::vector<DownRay> rays;
  rays.reserve(scanner.elevations_rad.size());
  for (const double elevation : scanner.elevations_rad)
  {
    const Vec3 d = rotate(T_base_sensor, {std::cos(elevation), 0, std::sin(elevation)});
    const double ahead = std::hypot(d.x, d.y);
    if (d.z >= 0) continue;
    const double range_m = T_base_sensor.z() / -d.z;
    if (range_m < scanner.min_range_m || range_m > scanner.max_range_m || d.x <= 0) continue;
    rays.push_back({T_base_sensor.x() + range_m * d.x, -d.z / ahead});
  }
  return rays;
}
}  // namespace

double narrowest_hole_m(
    const Scanner& scanner, const Pose& T_base_sensor, double speed_mps, const Stopping& stopping)
{
  // A ray looks into a hole from where it passes the near edge, on until it meets the far side less
  // than kFound_m down: there must be a sweep on this stretch, and the first of them soon enough.
  const double a_sweep_m = speed_mps / scanner.rate_hz;
  const double needed_m = stopping.front_m + stopping.way_m(speed_mps) + a_sweep_m;
  double least_m = std::numeric_limits<double>::infinity();
  for (const DownRay& ray : down_rays(scanner, T_base_sensor))
    if (ray.ground_m >= needed_m) least_m = std::min(least_m, kFound_m / ray.slope + a_sweep_m);
  return least_m;
}

double fastest_before_hole_mps(
    const Scanner& scanner, const Pose& T_base_sensor, double width_m, const Stopping& stopping)
{
  // A slower robot finds each hole that a faster one finds.
  int slow = 0, fast = 2001;
  while (fast - slow > 1)
  {
    const int middle = (slow + fast) / 2;
    const bool found = narrowest_hole_m(scanner, T_base_sensor, 0.01 * middle, stopping) <= width_m;
    (found ? slow : fast) = middle;
  }
  return 0.01 * slow;
}

double nearest_ground_m(const Scanner& scanner, const Pose& T_base_sensor)
{
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const DownRay& ray : down_rays(scanner, T_base_sensor))
    nearest_m = std::min(nearest_m, ray.ground_m);
  return nearest_m;
}

}  // namespace talus::sim
