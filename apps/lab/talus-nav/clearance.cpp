#include "clearance.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace talus::nav
{
namespace
{
constexpr double kStep_m = 0.03;  // of the fastest corner
constexpr double kMin_m = 0.04;
constexpr double kNoise_m = 0.01;  // of a place that stays where it is
constexpr double kNearer_m = 0.002;  // so little that it comes no nearer step by step

/** A place that must not come nearer than that to the outline. */
struct Kept
{
  double x_m, y_m, away_m, now_m;
  bool is_edge;
};

std::vector<Kept> near_places(
    const std::vector<BlockedPlace>& places, const Footprint& robot, double within_m, bool narrow)
{
  std::vector<Kept> out;
  double nearest_m = kKeepAway_m, nearest_edge_m = kKeepAway_m;
  for (const BlockedPlace& p : places)
  {
    if (std::hypot(p.x_m, p.y_m) >= within_m) continue;
    const bool close = narrow && !p.is_edge;
    out.push_back(
        {p.x_m, p.y_m, close ? kKeepAwayWhereNarrow_m : kKeepAway_m,
         robot.outside_m({p.x_m, p.y_m}), p.is_edge});
    if (p.is_edge)
      nearest_edge_m = std::min(nearest_edge_m, out.back().now_m);
    else if (!close)
      nearest_m = std::min(nearest_m, out.back().now_m);
  }
  // Less where it stands closer to one, as beside a wall.
  for (Kept& p : out)
    p.away_m =
        p.is_edge
            ? std::min(kKeepAway_m, nearest_edge_m - kNearer_m)
            : std::min({p.away_m, std::max(nearest_m - kNoise_m, kMin_m), p.now_m - kNoise_m});
  return out;
}

/** Whether a robot that went on for a time with these speeds keeps away. */
bool is_clear_after(
    const std::vector<Kept>& places, const Footprint& robot, double v_mps, double w_radps,
    double time_s)
{
  const double yaw_rad = w_radps * time_s, c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  const bool straight = std::abs(yaw_rad) < 1e-6;
  const double x_m = straight ? v_mps * time_s : v_mps / w_radps * s;
  const double y_m = straight ? 0 : v_mps / w_radps * (1 - c);
  return std::all_of(
      places.begin(), places.end(),
      [&](const Kept& p)
      {
        const double dx = p.x_m - x_m, dy = p.y_m - y_m;
        return robot.outside_m({c * dx + s * dy, -s * dx + c * dy}) >= p.away_m;
      });
}
}  // namespace

double clear_time_s(
    const std::vector<BlockedPlace>& places, const RobotBody& body, double v_mps, double w_radps,
    double most_s, bool narrow)
{
  const Footprint robot = body.footprint();
  const double corner_m = robot.reach_m();
  const double fastest_mps = std::abs(v_mps) + std::abs(w_radps) * corner_m;
  if (fastest_mps == 0) return most_s;
  const double step_s = kStep_m / fastest_mps;
  const auto near =
      near_places(places, robot, corner_m + kKeepAway_m + std::abs(v_mps) * most_s, narrow);
  for (double t = step_s; t < most_s + step_s; t += step_s)
    if (!is_clear_after(near, robot, v_mps, w_radps, t)) return t - step_s;
  return most_s;
}

}  // namespace talus::nav
