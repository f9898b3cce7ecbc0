#include "route.h"

#include "follow.h"

#include <mrpt/core/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace talus::nav
{
namespace
{
using mrpt::math::TPoint2D;

constexpr double kMargin_m = 1.5;
constexpr double kArrives_m =
    0.35;  // before the goal; a little less than MissionOptions::arrived_m
constexpr double kMap_m = 4;  // as far from the robot as the window of the shipped settings reaches
constexpr double kMax_m2 = 25000;  // 10 million cells, with the pictures 2 GB

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
  if (farthest_m <= Route::kFarthest_m + kMargin_m && size_m2 <= kMax_m2) return;
  throw std::invalid_argument(mrpt::format(
      "start, goal and objects reach from (%.1f, %.1f) to (%.1f, %.1f) m; the limit is %.0f m from "
      "the origin and %.0f m2: choose a nearer --goal, or move what is far away in the world",
      a.min_x_m, a.min_y_m, a.max_x_m, a.max_y_m, Route::kFarthest_m, kMax_m2));
}

}  // namespace

Route::Route(
    const sim::World& world, const TPoint2D& start, const TPoint2D& goal, double resolution_m,
    const RobotBody& body, GroundCostAt ground_cost)
    : goal_(goal), lattice_(body.length_m, body.width_m, resolution_m, std::move(ground_cost))
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

bool Route::plan(const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap)
{
  return plan_with(costmap, 0, robot);
}

bool Route::plan_beyond(
    const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap)
{
  return plan_with(costmap, kBeyond_m, robot);
}

bool Route::plan_with(
    const mrpt::maps::COccupancyGridMap2D& costmap, double around_m,
    const mrpt::math::TPose2D& robot)
{
  way_ = lattice_.plan(costmap, around_m, robot, goal_, kArrives_m);
  if (way_.empty()) return false;
  way_.insert(
      way_.begin(), {robot.x, robot.y, robot.phi, false, way_.front().narrow, way_.front().tilted});
  return true;
}

TPoint2D Route::target(const mrpt::math::TPose2D& robot, double ahead_m) const
{
  double left_m = ahead_m;
  for (std::size_t i = nearest_on(way_, robot); i + 1 < way_.size(); i++)
  {
    left_m -= std::hypot(way_[i + 1].x_m - way_[i].x_m, way_[i + 1].y_m - way_[i].y_m);
    if (left_m <= 0) return {way_[i + 1].x_m, way_[i + 1].y_m};
  }
  return {way_.back().x_m, way_.back().y_m};
}

}  // namespace talus::nav
