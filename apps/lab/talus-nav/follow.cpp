#include "follow.h"

#include <algorithm>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr double kFollowSpeed_mps = 0.3, kTurn_radps = 0.8, kSlowTurn_radps = 0.3;
constexpr double kLookAhead_m = 0.3;
constexpr double kThere_m = 0.05;
constexpr double kSharp_rad = 0.7;  // a bend at which a robot stops: more than one heading
constexpr double kTurnFrom_rad = 0.35, kTurnTo_rad = 0.08;

double between_rad(double from_rad, double to_rad)
{
  return std::remainder(to_rad - from_rad, 2 * M_PI);
}

double between_m(const RoutePose& a, const RoutePose& b)
{
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

bool is_turn(const RoutePose& a, const RoutePose& b) { return between_m(a, b) < 1e-6; }

/** The last pose at the place of this one. */
std::size_t last_here(const Route& route, std::size_t i)
{
  while (i + 1 < route.size() && is_turn(route[i], route[i + 1])) i++;
  return i;
}

/** The first pose from `i` on at which a robot has to stop: a sharp turn, a change of direction, or
 * the end. */
std::size_t end_of_leg(const Route& route, std::size_t i)
{
  for (; i + 1 < route.size(); i++)
  {
    const std::size_t last = last_here(route, i);
    const bool sharp = std::abs(between_rad(route[i].yaw_rad, route[last].yaw_rad)) > kSharp_rad;
    const bool reverses = last + 1 < route.size() && last > 0 && i > 0 &&
                          route[last + 1].backwards != route[i].backwards;
    if (sharp || reverses) return i;
    i = std::max(i, last);
  }
  return route.size() - 1;
}

Speeds turn(double off_rad)
{
  return {
      0, std::copysign(std::clamp(2 * std::abs(off_rad), kSlowTurn_radps, kTurn_radps), off_rad)};
}

template <class Holds>
bool any_ahead(const Route& route, const Pose2& robot, double ahead_m, const Holds& holds)
{
  double gone_m = 0;
  for (std::size_t i = nearest_on(route, robot); i < route.size() && gone_m <= ahead_m; i++)
  {
    if (holds(route[i])) return true;
    if (i + 1 < route.size()) gone_m += between_m(route[i], route[i + 1]);
  }
  return false;
}
}  // namespace

bool is_narrow(const Route& route, const Pose2& robot, double ahead_m)
{
  return any_ahead(
      route, robot, ahead_m, [](const RoutePose& p) { return p.narrow || p.backwards; });
}

bool is_tilted(const Route& route, const Pose2& robot, double ahead_m)
{
  return any_ahead(route, robot, ahead_m, [](const RoutePose& p) { return p.tilted; });
}

Speeds Follower::follow(const Route& route, const Pose2& robot)
{
  std::size_t at = nearest_on(route, robot);
  std::size_t end = end_of_leg(route, at);
  const auto away_m = [&](std::size_t i)
  { return std::hypot(route[i].x_m - robot.x_m, route[i].y_m - robot.y_m); };
  if (away_m(end) < kThere_m && end + 1 < route.size())
  {
    at = last_here(route, end);
    const double off_rad = between_rad(robot.yaw_rad, route[at].yaw_rad);
    turns_ = std::abs(off_rad) > (turns_ ? kTurnTo_rad : kTurnFrom_rad);
    if (turns_) return turn(off_rad);
    end = end_of_leg(route, at + 1);
  }
  std::size_t ahead = std::min(at + 1, end);
  while (ahead < end && away_m(ahead) < kLookAhead_m) ahead++;
  const bool backwards = route[ahead].backwards;
  auto to = robot.to_robot({route[ahead].x_m, route[ahead].y_m});
  if (backwards) to = {-to.x_m, -to.y_m};
  const double off_rad = std::atan2(to.y_m, to.x_m);
  turns_ = std::abs(off_rad) > (turns_ ? kTurnTo_rad : kTurnFrom_rad);
  if (turns_) return turn(off_rad);
  const double v_mps = std::min(kFollowSpeed_mps, std::max(0.08, 2 * away_m(ahead)));
  const double w_radps = std::clamp(
      v_mps * 2 * to.y_m / std::max(to.x_m * to.x_m + to.y_m * to.y_m, 0.01), -kTurn_radps,
      kTurn_radps);
  return {backwards ? -v_mps : v_mps, w_radps};
}

}  // namespace talus::nav
