#include "near_ground.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kCell_m = 0.5;
constexpr double kLow_m = 0.3, kHigh_m = 2.2;  // above the ground
constexpr double kNearest_m = 0.8, kFarthest_m = 12;  // from the sensor
constexpr double kMinPoints = 5;
constexpr double kMaxThick_m = 0.05, kMinLong_m = 0.1;  // standard deviations
constexpr double kParallel = 0.9;  // cosine between the normals of two pieces of one wall
constexpr double kAlong_m = 0.6;  // from the middle of one to that of the other

struct Sums
{
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, time_s = 0;
};

std::uint64_t cell_of(double x_m, double y_m)
{
  const auto index = [](double v) { return static_cast<std::int64_t>(std::floor(v / kCell_m)); };
  return (static_cast<std::uint64_t>(index(x_m)) << 32) ^
         (static_cast<std::uint64_t>(index(y_m)) & 0xffffffffU);
}

/** A facet where the points lie in a line; its length, 0 where they do not. */
double facet_from(const Sums& s, const Vec3& sensor, Facet& facet)
{
  if (s.n < kMinPoints) return 0;
  const double mx = s.x / s.n, my = s.y / s.n;
  const double xx = s.xx / s.n - mx * mx, xy = s.xy / s.n - mx * my, yy = s.yy / s.n - my * my;
  const double half = (xx + yy) / 2, root = std::hypot((xx - yy) / 2, xy);
  const double thick_m = std::sqrt(std::max(0.0, half - root)), long_m = std::sqrt(half + root);
  if (thick_m > kMaxThick_m || long_m < kMinLong_m || long_m < 3 * thick_m) return 0;
  const double along = std::atan2(2 * xy, xx - yy) / 2;
  facet = {
      mx,
      my,
      -std::sin(along),
      std::cos(along),
      std::atan2(my - sensor.y, mx - sensor.x),
      s.time_s / s.n};
  return long_m;
}
}  // namespace

std::vector<Facet> facets_of(
    const std::vector<Vec3>& points, const std::vector<float>& times_s, const NearPlane& ground,
    const Vec3& sensor, const Pose& T_map_base, std::size_t most)
{
  const double heading = std::atan2(T_map_base.m[4], T_map_base.m[0]);
  const double c = std::cos(heading), s = std::sin(heading);
  std::unordered_map<std::uint64_t, Sums> cells;
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    const Vec3& p = points[i];
    const double above_m = ground.distance_m(p);
    const double away_m = std::hypot(p.x - sensor.x, p.y - sensor.y);
    if (above_m < kLow_m || above_m > kHigh_m || away_m < kNearest_m || away_m > kFarthest_m)
      continue;
    const Vec3 v = turned(T_map_base, p);
    const double x = c * v.x + s * v.y, y = c * v.y - s * v.x;
    Sums& sums = cells[cell_of(x, y)];
    sums.n += 1, sums.x += x, sums.y += y, sums.time_s += times_s[i];
    sums.xx += x * x, sums.xy += x * y, sums.yy += y * y;
  }
  std::vector<std::pair<double, Facet>> found;
  Facet facet{};
  for (const auto& [cell, sums] : cells)
    if (const double long_m = facet_from(sums, sensor, facet); long_m > 0)
      found.emplace_back(long_m, facet);
  std::sort(
      found.begin(), found.end(),
      [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first > b.first : a.second.bearing_rad < b.second.bearing_rad;
      });
  if (found.size() > most) found.resize(most);
  std::vector<Facet> facets;
  facets.reserve(found.size());
  for (const auto& [long_m, f] : found) facets.push_back(f);
  return facets;
}

WallLine wall_line(const Facet& f, double x_m, double y_m, double heading_rad)
{
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  return {
      x_m + c * f.x_m - s * f.y_m, y_m + s * f.x_m + c * f.y_m, c * f.normal_x - s * f.normal_y,
      s * f.normal_x + c * f.normal_y};
}

void WallsApart::add(const std::vector<WallLine>& first, const std::vector<WallLine>& second)
{
  for (const WallLine& a : first)
  {
    double least_m = kMaxApart_m;
    for (const WallLine& b : second)
    {
      if (std::abs(a.normal_x * b.normal_x + a.normal_y * b.normal_y) < kParallel) continue;
      const double x = a.x_m - b.x_m, y = a.y_m - b.y_m;
      if (std::abs(x * b.normal_y - y * b.normal_x) < kAlong_m)
        least_m = std::min(least_m, std::abs(x * b.normal_x + y * b.normal_y));
    }
    sum_m += least_m;
    count += 1;
  }
}

double WallsApart::mean_m(double min_count) const
{
  return count < min_count ? std::numeric_limits<double>::quiet_NaN() : sum_m / count;
}

}  // namespace talus::hints
