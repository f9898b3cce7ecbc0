#include "near_ground.h"

#include <array>
#include <cmath>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
/** A point on the ground as the sensor has it. */
struct Seen
{
  double away_m, above_m;
};

bool runs_into(const Seen& nearer, const Seen& farther)
{
  const double ray_m = farther.above_m * nearer.away_m / farther.away_m;
  return ray_m - nearer.above_m < kOverGround_m;
}
}  // namespace

std::optional<double> buried_share(
    const std::vector<Vec3>& points, const NearPlane& ground, const Vec3& sensor)
{
  std::array<std::vector<Seen>, kDirections> seen;
  for (const Vec3& p : points)
    if (std::abs(ground.distance_m(p)) < kGroundBand_m && away_m(p, sensor) > kNear_m)
      seen[direction_of(p, sensor)].push_back({away_m(p, sensor), p.z - sensor.z});
  std::size_t pairs = 0, buried = 0;
  for (const auto& direction : seen)
    for (const Seen& nearer : direction)
      for (const Seen& farther : direction)
        if (farther.away_m > kMuchFarther * nearer.away_m)
          ++pairs, buried += runs_into(nearer, farther);
  if (pairs < kMinRayPairs) return {};
  return static_cast<double>(buried) / static_cast<double>(pairs);
}

}  // namespace talus::hints
