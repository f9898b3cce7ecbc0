#include "bag_clouds.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <unordered_set>

namespace talus::import
{
namespace
{
/** The cell of a point, and those beside it. */
std::uint64_t cell_of(const std::array<double, 3>& p_m, double size_m, int dx, int dy, int dz)
{
  constexpr std::uint64_t kBits = 21, kMask = (std::uint64_t{1} << kBits) - 1;
  const auto index = [&](double m, int d)
  {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(m / size_m)) + d) &
           kMask;
  };
  return index(p_m[0], dx) << 2 * kBits | index(p_m[1], dy) << kBits | index(p_m[2], dz);
}

std::array<double, 3> in_base(const mrpt::poses::CPose3D& T, const std::array<float, 3>& p)
{
  std::array<double, 3> moved{};
  T.composePoint(p[0], p[1], p[2], moved[0], moved[1], moved[2]);
  return moved;
}

using Point = std::array<double, 3>;
constexpr double kOnRobot_m = 3;  // from the frame of the points to the sensor
constexpr double kAlone_m = 0.3;  // points of one surface are closer there

double squared(const Point& a, const Point& b = {})
{
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

/** Of sorted points. */
bool stands_alone(const std::vector<Point>& points, const Point& point)
{
  const auto [first, last] = std::equal_range(points.begin(), points.end(), point);
  if (last - first != 1) return last != first;
  const auto is_near = [&](const Point& p) { return squared(p, point) < kAlone_m * kAlone_m; };
  for (auto p = first; p != points.begin() && (--p)->front() > point[0] - kAlone_m;)
    if (is_near(*p)) return false;
  for (auto p = last; p != points.end() && p->front() < point[0] + kAlone_m; ++p)
    if (is_near(*p)) return false;
  return true;
}
}  // namespace

void FirstClouds::add(const ScanFile& cloud, const std::string& frame, std::int64_t stamp_ns)
{
  constexpr std::size_t kMaxClouds = 5, kMaxPoints = 300000;
  if (clouds_.size() >= kMaxClouds || cloud.x_m.empty() || cloud.x_m.size() > kMaxPoints) return;
  clouds_.push_back({frame, stamp_ns, {}});
  for (std::size_t i = 0; i < cloud.x_m.size(); ++i)
    clouds_.back().points_m.push_back(
        {static_cast<float>(cloud.x_m[i]), static_cast<float>(cloud.y_m[i]),
         static_cast<float>(cloud.z_m[i])});
}

std::size_t FirstClouds::points() const
{
  std::size_t points = 0;
  for (const Cloud& cloud : clouds_) points += cloud.points_m.size();
  return points;
}

/** In one frame points may have been thinned out; what two sensors see is closer than a centimetre
 * by chance only. */
bool FirstClouds::are_in(const FirstClouds& whole, const Mounting& mounting) const
{
  constexpr std::int64_t kSameStamp_ns = 5000000;
  constexpr double kThinned_m = 0.1, kSame_m = 0.01, kNearlyAll = 0.95, kFarthest_m = 1e4;
  constexpr std::size_t kMinClouds = 3, kTried = 500;
  std::size_t compared = 0;
  for (const Cloud& part : clouds_)
    for (const Cloud& other : whole.clouds_)
    {
      if (std::abs(part.stamp_ns - other.stamp_ns) > kSameStamp_ns) continue;
      const auto T_part = mounting(part.frame, part.stamp_ns),
                 T_other = mounting(other.frame, other.stamp_ns);
      if (!T_part || !T_other) continue;
      const double size_m = part.frame == other.frame ? kThinned_m : kSame_m;
      std::unordered_set<std::uint64_t> cells;
      for (const auto& p : other.points_m)
        if (std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]) < kFarthest_m)
          cells.insert(cell_of(in_base(*T_other, p), size_m, 0, 0, 0));
      const std::size_t step = part.points_m.size() / kTried + 1;
      std::size_t tried = 0, found = 0;
      for (std::size_t i = 0; i < part.points_m.size(); i += step)
      {
        const auto p = in_base(*T_part, part.points_m[i]);
        if (!(std::hypot(p[0], p[1], p[2]) < kFarthest_m)) continue;
        bool is_near = false;
        for (int n = 0; n < 27 && !is_near; ++n)
          is_near = cells.count(cell_of(p, size_m, n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) > 0;
        ++tried;
        found += is_near ? 1 : 0;
      }
      if (static_cast<double>(found) < kNearlyAll * static_cast<double>(tried)) return false;
      compared += tried > 0 ? 1 : 0;
    }
  return compared >= kMinClouds;
}

bool NoReturns::add(const ScanFile& cloud)
{
  constexpr std::size_t kEnough = 10;
  if (cloud.x_m.empty()) return true;
  std::vector<Point> near;
  for (std::size_t i = 0; i < cloud.x_m.size(); ++i)
  {
    const Point p{cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]};
    if (squared(p) < std::pow(kOnRobot_m + kAlone_m, 2)) near.push_back(p);
  }
  std::sort(near.begin(), near.end());
  if (clouds_++ == 0)
  {
    std::unique_copy(near.begin(), near.end(), std::back_inserter(points_));
    const auto is_out = [](const Point& p)
    { return squared(p) == 0 || squared(p) > kOnRobot_m * kOnRobot_m; };
    points_.erase(std::remove_if(points_.begin(), points_.end(), is_out), points_.end());
  }
  const auto is_none = [&](const Point& p) { return !stands_alone(near, p); };
  points_.erase(std::remove_if(points_.begin(), points_.end(), is_none), points_.end());
  return clouds_ < kEnough;
}

std::vector<Point> NoReturns::points() const
{
  constexpr std::size_t kMinClouds = 5, kMaxSensors = 4;
  return clouds_ < kMinClouds || points_.size() > kMaxSensors ? std::vector<Point>() : points_;
}

}  // namespace talus::import
