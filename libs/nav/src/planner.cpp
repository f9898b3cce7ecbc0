#include <talus/nav/route.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "ground_cost.h"
#include "lattice.h"

namespace talus::nav
{
namespace
{
constexpr double kArrives_m = 0.35;
constexpr double kBeyond_m = 20;  // of unknown ground around the costmap, where all else fails
constexpr double kMargin_m = 1.5;  // around the goal
constexpr int kLooks = 16;
constexpr double kLookStep_m = 0.15;

// Of a retreat.
constexpr double kPatience_s = 5;  // longer than any turn on the spot
constexpr double kStands_m = 0.15;  // poses jump a little
constexpr double kBack_m = 0.8, kIsBack_m = 0.3;
constexpr double kTime_s = 6;  // to get there
constexpr double kTrailStep_m = 0.1;

double apart_m(const Point2& a, const Point2& b)
{
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

void require_finite(const Pose2& robot, const Point2& goal)
{
  if (!std::isfinite(robot.x_m + robot.y_m + robot.yaw_rad + goal.x_m + goal.y_m))
    throw std::invalid_argument("plan(): the pose of the robot or the goal is not finite");
}
}  // namespace

struct Planner::Impl
{
  Impl(const Footprint& f, Costmap c, const ObstacleOptions& o)
      : options(o), costmap(std::move(c)), lattice(f, costmap.resolution_m), ground(f)
  {
  }

  bool find(const Costmap& on, double around_m)
  {
    route = lattice.plan(on, around_m, here, goal, kArrives_m, *ground_cost);
    if (route.empty()) return false;
    const RoutePose& first = route.front();
    route.insert(
        route.begin(), {here.x_m, here.y_m, here.yaw_rad, false, first.narrow, first.tilted});
    return true;
  }

  /** A route over what must have been seen by now and was not, as behind a corner, and closely past
   * edges: whoever drives stops before the robot comes too near, and sees more from there. False
   * where that did not help. */
  bool look_from_here()
  {
    if (std::hypot(here.x_m - looks_from.x_m, here.y_m - looks_from.y_m) > kLookStep_m)
    {
      looks = 0;
      looks_from = here;
    }
    if (looks == kLooks) return false;
    looks++;
    Costmap daring = costmap;
    admit_doubtful(daring);
    for (float& p : daring.free)
      if (p <= kBlockedUpTo) p = 0;  // no margin of edges
    return find(daring, 0);
  }

  ObstacleOptions options;
  Costmap costmap;
  Lattice lattice;
  GroundCost ground;
  UnseenCells unseen;
  Route route;
  Pose2 here{}, looks_from{1e9, 1e9, 0};
  Point2 goal{};
  const GroundCostAt* ground_cost = nullptr;  //!< while it plans
  int looks = 0;  //!< plans from about there over what was not seen
};

Planner::Planner(const Footprint& robot, Costmap costmap, const ObstacleOptions& o)
    : impl_(std::make_unique<Impl>(robot, std::move(costmap), o))
{
}

Planner::~Planner() = default;

const Route& Planner::route() const { return impl_->route; }

Costmap& Planner::costmap() { return impl_->costmap; }
const Costmap& Planner::costmap() const { return impl_->costmap; }

bool Planner::plan(
    const Pose2& robot, const Point2& goal, const Costmap& known, const GroundCostAt& ground_cost)
{
  require_finite(robot, goal);
  Impl& p = *impl_;
  p.here = robot;
  p.goal = goal;
  p.ground_cost = &ground_cost;
  p.unseen.remember(robot, p.costmap, known);
  Costmap remembered = known, hoped = known;
  const bool remembers = p.unseen.block(remembered);
  admit_doubtful(hoped);  // to go and look
  return (remembers && p.find(remembered, 0)) || p.find(known, 0) || p.find(hoped, 0) ||
         p.look_from_here() || p.find(known, kBeyond_m) || p.find(hoped, kBeyond_m);
}

bool Planner::plan(const MapView& map, const Pose& T_map_base, const Point2& goal)
{
  require_finite(from_above(T_map_base), goal);
  Impl& p = *impl_;
  const Window w = map.window();
  const double side_m = w.cells * w.resolution_m;
  p.costmap.cover(w.min_x_m(), w.min_x_m() + side_m, w.min_y_m(), w.min_y_m() + side_m);
  p.costmap.cover(
      goal.x_m - kMargin_m, goal.x_m + kMargin_m, goal.y_m - kMargin_m, goal.y_m + kMargin_m);
  ObstacleOptions hopeful = p.options;
  hopeful.unseen = Unseen::Free;
  update_costmap(map, T_map_base, hopeful, p.costmap);
  Costmap known = p.costmap;
  update_costmap(map, T_map_base, p.options, known);
  p.ground.update(map);
  return plan(
      from_above(T_map_base), goal, known, [&](const Pose2& at) { return p.ground.cost(map, at); });
}

Route plan(
    const MapView& map, const Pose& T_map_base, const Point2& goal, const Footprint& robot,
    const ObstacleOptions& o)
{
  Planner planner(robot, Costmap{map.window().resolution_m, 0, 0, 0, 0, {}}, o);
  planner.plan(map, T_map_base, goal);
  return planner.route();
}

std::size_t nearest_on(const Route& route, const Pose2& robot)
{
  const auto away_m = [&robot](const RoutePose& p)
  { return std::hypot(p.x_m - robot.x_m, p.y_m - robot.y_m); };
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < route.size(); i++)
    if (away_m(route[i]) < away_m(route[nearest])) nearest = i;
  return nearest;
}

Point2 point_ahead(const Route& route, const Pose2& robot, double ahead_m)
{
  double left_m = ahead_m;
  for (std::size_t i = nearest_on(route, robot); i + 1 < route.size(); i++)
  {
    left_m -= std::hypot(route[i + 1].x_m - route[i].x_m, route[i + 1].y_m - route[i].y_m);
    if (left_m <= 0) return {route[i + 1].x_m, route[i + 1].y_m};
  }
  return {route.back().x_m, route.back().y_m};
}

std::optional<Point2> Retreat::target(double time_s, const Point2& at)
{
  follow(time_s, at);
  if (going_back_to_ && (time_s > give_up_s_ || apart_m(at, *going_back_to_) < kIsBack_m))
  {
    going_back_to_.reset();
    stands_since_s_ = time_s;
  }
  if (!going_back_to_ && time_s - stands_since_s_ > kPatience_s)
  {
    going_back_to_ = position_behind(at);
    give_up_s_ = time_s + kTime_s;
    if (!going_back_to_) stands_since_s_ = time_s;
  }
  return going_back_to_;
}

void Retreat::follow(double time_s, const Point2& at)
{
  if (trail_.empty() || apart_m(at, trail_.back()) > kTrailStep_m) trail_.push_back(at);
  if (apart_m(at, stands_at_) < kStands_m) return;
  stands_at_ = at;
  stands_since_s_ = time_s;
}

std::optional<Point2> Retreat::position_behind(const Point2& at) const
{
  for (auto at_then = trail_.rbegin(); at_then != trail_.rend(); ++at_then)
    if (apart_m(at, *at_then) > kBack_m) return *at_then;
  return std::nullopt;
}

}  // namespace talus::nav
