#include "near_ground.h"

#include <algorithm>
#include <cmath>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kBefore_m = 0.15;  // nearer by that than the thing: its foot is ground, too

}  // namespace

void GroundBefore::add(const std::vector<Vec3>& points, const NearPlane& ground, const Vec3& sensor)
{
  auto& nearest_m = nearest_m_.emplace_back();
  nearest_m.fill(HUGE_VALF);
  for (const Vec3& p : points)
  {
    if (std::abs(ground.distance_m(p)) > kOnGround_m) continue;
    float& least_m = nearest_m[direction_of(p, sensor)];
    least_m = std::min(least_m, static_cast<float>(away_m(p, sensor)));
  }
}

double GroundBefore::share_before(const Vec3& p, const Vec3& sensor) const
{
  if (nearest_m_.empty()) return 0;
  const std::size_t direction = direction_of(p, sensor);
  const double least_m = away_m(p, sensor) - kBefore_m;
  const auto seen = std::count_if(
      nearest_m_.begin(), nearest_m_.end(),
      [&](const auto& nearest_m) { return static_cast<double>(nearest_m[direction]) < least_m; });
  return static_cast<double>(seen) / static_cast<double>(nearest_m_.size());
}

}  // namespace talus::hints
