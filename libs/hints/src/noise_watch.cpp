#include "judge.h"

#include <cmath>
#include <unordered_map>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kSmallCell_m = 0.15;  // hardly any slope or roughness within it
constexpr int kMinHitsInside = 5;

struct Sums
{
  int n = 0;
  double d = 0, dd = 0;
};
}  // namespace

void note_spreads(const std::vector<Vec3>& points, const NearPlane& ground, Values& spreads_m)
{
  std::unordered_map<std::int64_t, Sums> cells;
  for (const Vec3& p : points)
  {
    const double d = ground.distance_m(p);
    if (std::abs(d) > kGroundBand_m / 2) continue;
    const auto x = static_cast<std::int64_t>(std::floor(p.x / kSmallCell_m));
    const auto y = static_cast<std::int64_t>(std::floor(p.y / kSmallCell_m));
    Sums& s = cells[x * 100003 + y];
    ++s.n;
    s.d += d;
    s.dd += d * d;
  }
  for (const auto& [key, s] : cells)
    if (s.n >= kMinHitsInside)
      spreads_m.add(std::sqrt(std::max(0.0, (s.dd - s.d * s.d / s.n) / (s.n - 1))));
}

}  // namespace talus::hints
