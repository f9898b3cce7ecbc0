#include "start_costmap.h"

#include <mrpt/core/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus::nav
{
namespace
{
constexpr double kMargin_m = 1.5;
constexpr double kMax_m2 = 25000;  // 10 million cells, with the pictures 2 GB

struct Area
{
  double min_x_m, max_x_m, min_y_m, max_y_m;
};

/** Start, goal and all that stands in the world, with a margin. */
Area area_of(const sim::World& world, const Point2& start, const Point2& goal)
{
  Area a{
      std::min(start.x_m, goal.x_m), std::max(start.x_m, goal.x_m), std::min(start.y_m, goal.y_m),
      std::max(start.y_m, goal.y_m)};
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
  if (farthest_m <= kFarthest_m + kMargin_m && size_m2 <= kMax_m2) return;
  throw std::invalid_argument(mrpt::format(
      "start, goal and objects reach from (%.1f, %.1f) to (%.1f, %.1f) m; the limit is %.0f m from "
      "the origin and %.0f m2: choose a nearer --goal, or move what is far away in the world",
      a.min_x_m, a.min_y_m, a.max_x_m, a.max_y_m, kFarthest_m, kMax_m2));
}

}  // namespace

Costmap start_costmap(
    const sim::World& world, const Point2& start, const Point2& goal, double resolution_m)
{
  const Area area = area_of(world, start, goal);
  require_manageable(area);
  const auto up = [&](double v) { return std::ceil(v / resolution_m) * resolution_m; };
  Costmap out{resolution_m, 0, 0, 0, 0, {}};
  out.cover(area.min_x_m, up(area.max_x_m), area.min_y_m, up(area.max_y_m));
  return out;
}

}  // namespace talus::nav
