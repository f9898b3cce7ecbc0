#include <algorithm>
#include <cmath>

#include "world_parts.h"

namespace talus::sim
{
namespace
{
constexpr double kStep_m = 0.1;  //!< along the way
constexpr double kMostSteps = 10000;  //!< from one stop to the next, however far that is
constexpr double kGrid_m = 0.025;  //!< of vertical lines through what two bodies may share
constexpr double kMostLines = 100;  //!< along each axis
constexpr double kOver_m = 0.2;  //!< what is lower, a mover steps or rides over
constexpr double kGraze_m = 0.01;  //!< less of a line in both is no collision

/** What the bounds of two bodies share; empty where a minimum is not below its maximum. */
Bounds shared(const Bounds& a, const Bounds& b)
{
  return {
      {std::max(a.min_m.x, b.min_m.x), std::max(a.min_m.y, b.min_m.y),
       std::max(a.min_m.z, b.min_m.z)},
      {std::min(a.max_m.x, b.max_m.x), std::min(a.max_m.y, b.max_m.y),
       std::min(a.max_m.z, b.max_m.z)}};
}

/** Whether two bodies overlap on the vertical line at a place, above a height. */
bool overlap_at(const Shape& a, const Shape& b, double x_m, double y_m, double above_m)
{
  std::vector<Span> of_a, of_b;
  column(a, x_m, y_m, of_a);
  column(b, x_m, y_m, of_b);
  if (of_a.empty() || of_b.empty()) return false;
  const double low = std::max({of_a[0].enter_m, of_b[0].enter_m, above_m});
  return std::min(of_a[0].exit_m, of_b[0].exit_m) > low + kGraze_m;
}

bool overlap(const Shape& a, const Shape& b, double above_m)
{
  const Bounds area = shared(bounds(a), bounds(b));
  const double size_x = area.max_m.x - area.min_m.x, size_y = area.max_m.y - area.min_m.y;
  if (size_x <= 0 || size_y <= 0 || area.max_m.z <= std::max(area.min_m.z, above_m)) return false;
  const double nx = std::ceil(std::min(size_x / kGrid_m, kMostLines));
  const double ny = std::ceil(std::min(size_y / kGrid_m, kMostLines));
  for (double i = 0.5; i < nx; ++i)
    for (double j = 0.5; j < ny; ++j)
    {
      const double x = area.min_m.x + size_x * i / nx, y = area.min_m.y + size_y * j / ny;
      if (overlap_at(a, b, x, y, above_m)) return true;
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
    const double way_m = std::hypot(b.x_m - a.x_m, b.y_m - a.y_m);
    const double steps = std::clamp(std::ceil(way_m / kStep_m), 1.0, kMostSteps);
    for (double s = 1; s <= steps; ++s)
      times.push_back(a.time_s + (b.time_s - a.time_s) * s / steps);
  }
  return times;
}

}  // namespace

std::optional<Collision> first_collision(const Mover& mover, const World& world)
{
  for (const double time_s : times_along(mover.path))
  {
    const Pose at = mover.pose(time_s);
    const double above_m = world.ground.height_m(at.x(), at.y()) + kOver_m;
    for (const Shape& body : mover.placed(time_s, world.ground))
      for (const Shape& thing : world.objects.shapes())
        if (thing.mean_free_path_m == 0 && overlap(body, thing, above_m))
          return Collision{time_s, at.x(), at.y()};
  }
  return std::nullopt;
}

}  // namespace talus::sim
