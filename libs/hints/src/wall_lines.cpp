#include "wall_lines.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kParallel = 0.9;  // cosine between the normals of two pieces of one wall
constexpr double kAlong_m = 0.6;  // from the middle of one to that of the other
constexpr double kMaxApart_m = 0.3;  // what is farther apart counts as that
}  // namespace

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
    sum_m_ += least_m;
    count_ += 1;
  }
}

double WallsApart::mean_m() const
{
  return count_ < kMinCompared ? std::numeric_limits<double>::quiet_NaN() : sum_m_ / count_;
}

}  // namespace talus::hints
