#include <algorithm>
#include <cmath>

#include "world_parts.h"

namespace talus::sim
{
namespace
{
constexpr double kStep_m = 0.1;  //!< along the way
constexpr double kGrid_m = 0.025;  //!< of vertical lines through the mover
constexpr double kOver_m = 0.2;  //!< what is lower, a mover steps or rides over
constexpr double kGraze_m = 0.01;  //!< less of a line in both is no collision

ShapeTree solid_ones(const ShapeTree& objects)
{
  std::vector<Shape> solid;
  for (const Shape& s : objects.shapes())
    if (s.mean_free_path_m == 0) solid.push_back(s);
  return ShapeTree(std::move(solid));
}

/** Whether a shape and one of the objects overlap above a height. */
bool overlap(const Shape& shape, const ShapeTree& objects, double above_m)
{
  const Bounds area = bounds(shape);
  std::vector<Span> of_shape, of_objects;
  for (double x = area.min_m.x + 0.5 * kGrid_m; x < area.max_m.x; x += kGrid_m)
    for (double y = area.min_m.y + 0.5 * kGrid_m; y < area.max_m.y; y += kGrid_m)
    {
      of_shape.clear(), of_objects.clear();
      column(shape, x, y, of_shape);
      if (of_shape.empty()) continue;
      objects.column(x, y, of_objects);
      for (const Span& o : of_objects)
      {
        const double low = std::max({o.enter_m, of_shape[0].enter_m, above_m});
        if (std::min(o.exit_m, of_shape[0].exit_m) > low + kGraze_m) return true;
      }
    }
  return false;
}

/** Times at which a mover has gone one step after the other. */
std::vector<double> times_along(const std::vector<Mover::Stop>& path)
{
  std::vector<double> times{path[0].time_s};
  for (std::size_t i = 1; i < path.size(); ++i)
  {
    const Mover::Stop &a = path[i - 1], &b = path[i];
    const int steps = std::max(
        1, static_cast<int>(std::ceil(std::hypot(b.x_m - a.x_m, b.y_m - a.y_m) / kStep_m)));
    for (int s = 1; s <= steps; ++s) times.push_back(a.time_s + (b.time_s - a.time_s) * s / steps);
  }
  return times;
}

}  // namespace

std::optional<Collision> first_collision(const Mover& mover, const World& world)
{
  const ShapeTree solid = solid_ones(world.objects);
  for (const double time_s : times_along(mover.path))
  {
    const Pose at = mover.pose(time_s);
    const double above_m = world.ground.height_m(at.x(), at.y()) + kOver_m;
    for (const Shape& shape : mover.placed(time_s, world.ground))
      if (overlap(shape, solid, above_m)) return Collision{time_s, at.x(), at.y()};
  }
  return std::nullopt;
}

}  // namespace talus::sim
