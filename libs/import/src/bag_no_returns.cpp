#include "bag_no_returns.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace talus::import
{
namespace
{
using Place = std::array<double, 3>;
constexpr double kOnRobot_m = 3;  // from the frame of the points to the sensor
constexpr double kAlone_m = 0.3;  // points of one surface are closer there

double squared(const Place& a, const Place& b = {})
{
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

/** Of sorted points. */
bool stands_alone(const std::vector<Place>& points, const Place& place)
{
  const auto [first, last] = std::equal_range(points.begin(), points.end(), place);
  if (last - first != 1) return last != first;
  const auto is_near = [&](const Place& p) { return squared(p, place) < kAlone_m * kAlone_m; };
  for (auto p = first; p != points.begin() && (--p)->front() > place[0] - kAlone_m;)
    if (is_near(*p)) return false;
  for (auto p = last; p != points.end() && p->front() < place[0] + kAlone_m; ++p)
    if (is_near(*p)) return false;
  return true;
}
}  // namespace

bool NoReturns::add(const ScanFile& cloud)
{
  constexpr std::size_t kEnough = 10;
  if (cloud.x_m.empty()) return true;
  std::vector<Place> near;
  for (std::size_t i = 0; i < cloud.x_m.size(); ++i)
  {
    const Place p{cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]};
    if (squared(p) < std::pow(kOnRobot_m + kAlone_m, 2)) near.push_back(p);
  }
  std::sort(near.begin(), near.end());
  if (clouds_++ == 0)
  {
    std::unique_copy(near.begin(), near.end(), std::back_inserter(places_));
    const auto is_out = [](const Place& p)
    { return squared(p) == 0 || squared(p) > kOnRobot_m * kOnRobot_m; };
    places_.erase(std::remove_if(places_.begin(), places_.end(), is_out), places_.end());
  }
  const auto is_none = [&](const Place& p) { return !stands_alone(near, p); };
  places_.erase(std::remove_if(places_.begin(), places_.end(), is_none), places_.end());
  return clouds_ < kEnough;
}

std::vector<Place> NoReturns::places() const
{
  constexpr std::size_t kMinClouds = 5, kMaxSensors = 4;
  return clouds_ < kMinClouds || places_.size() > kMaxSensors ? std::vector<Place>() : places_;
}

}  // namespace talus::import
