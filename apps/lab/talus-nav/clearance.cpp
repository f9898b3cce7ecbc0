#include "clearance.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace talus::nav
{
namespace
{
constexpr double kStep_m = 0.03;  // of the fastest corner
constexpr double kLeast_m = 0.04;
constexpr double kNoise_m = 0.01;  // of a point that stays where it is

struct Place
{
  double x_m, y_m;
};

/** The place in the frame of a robot that has gone on for a time with these speeds. */
Place seen_after(const Place& p, double v_mps, double w_radps, double time_s)
{
  const double yaw_rad = w_radps * time_s, c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  const bool straight = std::abs(yaw_rad) < 1e-6;
  const double x_m = straight ? v_mps * time_s : v_mps / w_radps * s;
  const double y_m = straight ? 0 : v_mps / w_radps * (1 - c);
  const double dx = p.x_m - x_m, dy = p.y_m - y_m;
  return {c * dx + s * dy, -s * dx + c * dy};
}

std::vector<Place> near_places(const mrpt::maps::CSimplePointsMap& points, double within_m)
{
  std::vector<Place> out;
  for (std::size_t i = 0; i < points.size(); i++)
  {
    const Place p{points.getPointsBufferRef_x()[i], points.getPointsBufferRef_y()[i]};
    if (std::hypot(p.x_m, p.y_m) < within_m) out.push_back(p);
  }
  return out;
}

/** 0 inside of the outline. */
double to_outline_m(const Place& p, const RobotBody& body)
{
  return std::hypot(
      std::max(0.0, std::abs(p.x_m) - body.length_m / 2),
      std::max(0.0, std::abs(p.y_m) - body.width_m / 2));
}

/** What the points have to be away while the robot moves: less where it stands closer to one, as
 * beside a wall. */
double least_of(const std::vector<double>& now_m)
{
  const double nearest_m =
      now_m.empty() ? kKeepAway_m : *std::min_element(now_m.begin(), now_m.end());
  return std::clamp(nearest_m - kNoise_m, kLeast_m, kKeepAway_m);
}
}  // namespace

double clear_time_s(
    const mrpt::maps::CSimplePointsMap& points, const RobotBody& body, double v_mps, double w_radps,
    double most_s)
{
  const double corner_m = std::hypot(body.length_m, body.width_m) / 2;
  const double fastest_mps = std::abs(v_mps) + std::abs(w_radps) * corner_m;
  if (fastest_mps == 0) return most_s;
  const double step_s = kStep_m / fastest_mps;
  const auto places = near_places(points, corner_m + kKeepAway_m + std::abs(v_mps) * most_s);
  std::vector<double> now_m(places.size());
  std::transform(
      places.begin(), places.end(), now_m.begin(),
      [&](const Place& p) { return to_outline_m(p, body); });
  const double least_m = least_of(now_m);
  double clear_s = most_s;
  for (std::size_t i = 0; i < places.size(); i++)
    for (double t = step_s; t < clear_s + step_s; t += step_s)
      if (to_outline_m(seen_after(places[i], v_mps, w_radps, t), body) <
          std::min(least_m, now_m[i] - kNoise_m))
        clear_s = t - step_s;
  return clear_s;
}

}  // namespace talus::nav
