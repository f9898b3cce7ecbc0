#include "route.h"

#include <mrpt/core/format.h>
#include <mrpt/nav/planners/PlannerSimple2D.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>

namespace talus::nav
{
namespace
{
using mrpt::math::TPoint2D;

constexpr double kMargin_m = 1.5;
constexpr double kArrives_m =
    0.35;  // before the goal; a little less than MissionOptions::arrived_m
constexpr double kMap_m = 4;  // as far from the robot as the window of the shipped settings reaches
constexpr double kMost_m2 = 25000;  // 10 million cells, with the pictures 2 GB

struct Area
{
  double min_x_m, max_x_m, min_y_m, max_y_m;
};

/** Start, goal and all that stands in the world, with a margin. */
Area area_of(const sim::World& world, const TPoint2D& start, const TPoint2D& goal)
{
  Area a{
      std::min(start.x, goal.x), std::max(start.x, goal.x), std::min(start.y, goal.y),
      std::max(start.y, goal.y)};
  for (const auto& shape : world.objects.shapes())
  {
    const auto b = sim::bounds(shape);
    a.min_x_m = std::min(a.min_x_m, b.min_m.x);
    a.max_x_m = std::max(a.max_x_m, b.max_m.x);
    a.min_y_m = std::min(a.min_y_m, b.min_m.y);
    a.max_y_m = std::max(a.max_y_m, b.max_m.y);
  }
  return {
      a.min_x_m - kMargin_m, a.max_x_m + kMargin_m, a.min_y_m - kMargin_m, a.max_y_m + kMargin_m};
}

void require_manageable(const Area& a)
{
  const double size_m2 = (a.max_x_m - a.min_x_m) * (a.max_y_m - a.min_y_m);
  const double farthest_m = std::max({-a.min_x_m, a.max_x_m, -a.min_y_m, a.max_y_m});
  if (farthest_m <= Route::kFarthest_m + kMargin_m && size_m2 <= kMost_m2) return;
  throw std::invalid_argument(mrpt::format(
      "start, goal and objects reach from (%.1f, %.1f) to (%.1f, %.1f) m; the limit is %.0f m from "
      "the origin and %.0f m2: choose a nearer --goal, or move what is far away in the world",
      a.min_x_m, a.min_y_m, a.max_x_m, a.max_y_m, Route::kFarthest_m, kMost_m2));
}

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

/** With cells twice as long, each as bad as the worst in it, and unknown ground around. */
mrpt::maps::COccupancyGridMap2D halved(const mrpt::maps::COccupancyGridMap2D& grid, double around_m)
{
  const double cell = 2 * grid.getResolution();
  const auto down = [&](double v) { return static_cast<float>(std::floor(v / cell) * cell); };
  mrpt::maps::COccupancyGridMap2D wide;
  wide.setSize(
      down(grid.getXMin() - around_m), down(grid.getXMax() + around_m),
      down(grid.getYMin() - around_m), down(grid.getYMax() + around_m), static_cast<float>(cell),
      1.0F);
  for (int y = 0; y < static_cast<int>(grid.getSizeY()); y++)
    for (int x = 0; x < static_cast<int>(grid.getSizeX()); x++)
    {
      const int to_x = wide.x2idx(grid.idx2x(static_cast<std::size_t>(x)));
      const int to_y = wide.y2idx(grid.idx2y(static_cast<std::size_t>(y)));
      wide.setCell(to_x, to_y, std::min(wide.getCell(to_x, to_y), grid.getCell(x, y)));
    }
  return wide;
}
}  // namespace

Route::Route(
    const sim::World& world, const TPoint2D& start, const TPoint2D& goal, double resolution_m,
    double robot_radius_m)
    : goal_(goal), robot_radius_m_(robot_radius_m)
{
  const Area area = area_of(world, start, goal);
  require_manageable(area);
  const auto down = [&](double v) { return std::floor(v / resolution_m) * resolution_m; };
  const auto up = [&](double v) { return std::ceil(v / resolution_m) * resolution_m; };
  costmap_.setSize(
      static_cast<float>(down(area.min_x_m)), static_cast<float>(up(area.max_x_m)),
      static_cast<float>(down(area.min_y_m)), static_cast<float>(up(area.max_y_m)),
      static_cast<float>(resolution_m), kHopeful);
}

void Route::cover(const mrpt::math::TPose2D& robot)
{
  const double cell = costmap_.getResolution();
  const auto down = [cell](double v) { return static_cast<float>(std::floor(v / cell) * cell); };
  costmap_.resizeGrid(
      down(robot.x - kMap_m), down(robot.x + kMap_m), down(robot.y - kMap_m),
      down(robot.y + kMap_m), kHopeful, false);
}

bool Route::plan_beyond(
    const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap)
{
  way_.clear();
  auto wide = halved(costmap, kBeyond_m);
  if (plan_with(wide, robot, robot_radius_m_, goal_)) return true;
  clear_around(wide, robot, robot_radius_m_);
  return plan_with(wide, robot, 0.8 * robot_radius_m_, goal_);
}

bool Route::plan(const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap)
{
  way_.clear();
  // A robot that came too near to an obstacle must find away from it.
  for (const double share : {1.0, 0.8, 0.65})
    if (plan_with(costmap, robot, share * robot_radius_m_, goal_)) return true;
  auto around_cleared = costmap;
  clear_around(around_cleared, robot, robot_radius_m_);
  return plan_with(around_cleared, robot, 0.65 * robot_radius_m_, goal_) ||
         plan_with(around_cleared, robot, 0.65 * robot_radius_m_, before_goal(robot));
}

/** A place from where the robot has arrived, for a goal whose surroundings are blocked or not seen.
 */
TPoint2D Route::before_goal(const mrpt::math::TPose2D& robot) const
{
  const double back_x_m = robot.x - goal_.x, back_y_m = robot.y - goal_.y;
  const double part = std::min(1.0, kArrives_m / std::max(std::hypot(back_x_m, back_y_m), 1e-9));
  return {goal_.x + part * back_x_m, goal_.y + part * back_y_m};
}

bool Route::plan_with(
    const mrpt::maps::COccupancyGridMap2D& costmap, const mrpt::math::TPose2D& robot,
    double radius_m, const TPoint2D& to)
{
  mrpt::nav::PlannerSimple2D planner;
  planner.robotRadius = static_cast<float>(radius_m);
  planner.minStepInReturnedPath = 0.2F;
  planner.occupancyThreshold = kBlocked;
  std::deque<TPoint2D> path;
  bool not_found = true;
  planner.computePath(
      costmap, mrpt::poses::CPose2D(robot), mrpt::poses::CPose2D(to.x, to.y, 0), path, not_found);
  if (not_found) return false;
  way_.assign(path.begin(), path.end());
  way_.insert(way_.begin(), TPoint2D(robot.x, robot.y));
  way_.push_back(to);
  return true;
}

TPoint2D Route::target(const mrpt::math::TPose2D& robot, double ahead_m) const
{
  const auto away_m = [&robot](const TPoint2D& p)
  { return std::hypot(p.x - robot.x, p.y - robot.y); };
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < way_.size(); i++)
    if (away_m(way_[i]) < away_m(way_[nearest])) nearest = i;
  double left_m = ahead_m;
  for (std::size_t i = nearest; i + 1 < way_.size(); i++)
  {
    left_m -= std::hypot(way_[i + 1].x - way_[i].x, way_[i + 1].y - way_[i].y);
    if (left_m <= 0) return way_[i + 1];
  }
  return way_.back();
}

}  // namespace talus::nav
