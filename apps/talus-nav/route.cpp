#include "route.h"

#include <mrpt/nav/planners/PlannerSimple2D.h>

#include <algorithm>
#include <cmath>
#include <deque>

namespace talus::nav
{
namespace
{
using mrpt::math::TPoint2D;

constexpr double kMargin_m = 1.5;

/** What is nearer to the robot is left to the reactive navigator. */
void clear_around(
    mrpt::maps::COccupancyGridMap2D& grid, const mrpt::math::TPose2D& robot, double radius_m)
{
  const double cell = grid.getResolution();
  for (double dy = -radius_m; dy <= radius_m; dy += cell)
    for (double dx = -radius_m; dx <= radius_m; dx += cell)
      if (dx * dx + dy * dy <= radius_m * radius_m)
        grid.setPos(
            static_cast<float>(robot.x + dx), static_cast<float>(robot.y + dy), Route::kHopeful);
}
}  // namespace

Route::Route(
    const sim::World& world, const TPoint2D& start, const TPoint2D& goal, double resolution_m,
    double robot_radius_m)
    : goal_(goal), robot_radius_m_(robot_radius_m)
{
  double x0 = std::min(start.x, goal.x), x1 = std::max(start.x, goal.x);
  double y0 = std::min(start.y, goal.y), y1 = std::max(start.y, goal.y);
  for (const auto& shape : world.objects.shapes())
  {
    const auto b = sim::bounds(shape);
    x0 = std::min(x0, b.min_m.x);
    x1 = std::max(x1, b.max_m.x);
    y0 = std::min(y0, b.min_m.y);
    y1 = std::max(y1, b.max_m.y);
  }
  const auto down = [&](double v) { return std::floor(v / resolution_m) * resolution_m; };
  const auto up = [&](double v) { return std::ceil(v / resolution_m) * resolution_m; };
  costmap_.setSize(
      static_cast<float>(down(x0 - kMargin_m)), static_cast<float>(up(x1 + kMargin_m)),
      static_cast<float>(down(y0 - kMargin_m)), static_cast<float>(up(y1 + kMargin_m)),
      static_cast<float>(resolution_m), kHopeful);
}

bool Route::plan(const mrpt::math::TPose2D& robot)
{
  way_.clear();
  // A robot that came too near to an obstacle must find away from it.
  for (const double share : {1.0, 0.8, 0.65})
    if (plan_with(costmap_, robot, share * robot_radius_m_)) return true;
  auto around_cleared = costmap_;
  clear_around(around_cleared, robot, 0.85 * robot_radius_m_);
  return plan_with(around_cleared, robot, 0.65 * robot_radius_m_);
}

bool Route::plan_with(
    const mrpt::maps::COccupancyGridMap2D& costmap, const mrpt::math::TPose2D& robot,
    double radius_m)
{
  mrpt::nav::PlannerSimple2D planner;
  planner.robotRadius = static_cast<float>(radius_m);
  planner.minStepInReturnedPath = 0.2F;
  planner.occupancyThreshold = 0.45F;
  std::deque<TPoint2D> path;
  bool not_found = true;
  planner.computePath(
      costmap, mrpt::poses::CPose2D(robot), mrpt::poses::CPose2D(goal_.x, goal_.y, 0), path,
      not_found);
  if (not_found) return false;
  way_.assign(path.begin(), path.end());
  way_.insert(way_.begin(), TPoint2D(robot.x, robot.y));
  way_.push_back(goal_);
  return true;
}

TPoint2D Route::target(const mrpt::math::TPose2D& robot, double ahead_m) const
{
  const TPoint2D here(robot.x, robot.y);
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < way_.size(); i++)
    if ((way_[i] - here).norm() < (way_[nearest] - here).norm()) nearest = i;
  double left = ahead_m;
  for (std::size_t i = nearest; i + 1 < way_.size(); i++)
  {
    left -= (way_[i + 1] - way_[i]).norm();
    if (left <= 0) return way_[i + 1];
  }
  return goal_;
}

}  // namespace talus::nav
