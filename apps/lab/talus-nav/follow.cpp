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

/** How far a place is from the outline; negative: it is inside. */
double from_outline_m(const Footprint& f, const Point2& p)
{
  const double beyond_m =
      std::max({p.x_m - f.max_x_m, f.min_x_m - p.x_m, p.y_m - f.max_y_m, f.min_y_m - p.y_m});
  return beyond_m < 0 ? beyond_m : f.outside_m(p);
}

std::vector<Kept> near_places(
    const std::vector<BlockedPlace>& places, const Footprint& robot, double within_m, bool narrow)
{
  std::vector<Kept> out;
  double nearest_m = kKeepAway_m;
  for (const BlockedPlace& p : places)
  {
    if (std::hypot(p.x_m, p.y_m) >= within_m) continue;
    const bool close = narrow && !p.is_edge;
    const double away_m = close ? kKeepAwayWhereNarrow_m : kKeepAway_m;
    out.push_back({p.x_m, p.y_m, away_m, from_outline_m(robot, {p.x_m, p.y_m}), p.is_edge});
    if (!p.is_edge && !close) nearest_m = std::min(nearest_m, out.back().now_m);
  }
  for (Kept& p : out)
    if (p.is_edge)
      p.away_m = std::min(p.away_m, p.now_m - kNearer_m);
    else  // less where it stands closer to one, as beside a wall
      p.away_m = std::min({p.away_m, std::max(nearest_m - kNoise_m, kMin_m), p.now_m - kNoise_m});
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
        return from_outline_m(robot, {c * dx + s * dy, -s * dx + c * dy}) >= p.away_m;
      });
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

double clear_time_s(
    const std::vector<BlockedPlace>& places, const RobotBody& body, double v_mps, double w_radps,
    double max_s, bool narrow)
{
  const Footprint robot = body.footprint();
  const double corner_m = robot.reach_m();
  const double fastest_mps = std::abs(v_mps) + std::abs(w_radps) * corner_m;
  if (fastest_mps == 0) return max_s;
  const double step_s = kStep_m / fastest_mps;
  const auto near =
      near_places(places, robot, corner_m + kKeepAway_m + std::abs(v_mps) * max_s, narrow);
  for (double t = step_s; t < max_s + step_s; t += step_s)
    if (!is_clear_after(near, robot, v_mps, w_radps, t)) return t - step_s;
  return max_s;
}

}  // namespace talus::nav
