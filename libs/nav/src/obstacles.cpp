#include <talus/nav/obstacles.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "surface_view.h"

namespace talus::nav
{
namespace
{
/** Whether a cell, an obstacle, has a neighbour in the window that is none. */
bool on_boundary(const std::vector<Passage>& cells, int n, int ix, int iy)
{
  for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
  {
    const int x = ix + dx, y = iy + dy;
    if (x < 0 || y < 0 || x >= n || y >= n) continue;
    if (cells[static_cast<std::size_t>(y * n + x)] != Passage::Obstacle) return true;
  }
  return false;
}

/** Row and column of a square of the spacing: whole numbers, which may be greater than an integer.
 */
using Square = std::pair<double, double>;

/** A cell that is given to the planner, robot frame seen from above. */
struct Obstacle
{
  double x_m, y_m;
  double height_m;  //!< above the ground of its cell
  Square square;
};

/** The squares lie fixed in the map, so that points do not flicker while the robot moves. */
Square square_of(double x_map, double y_map, double spacing_m)
{
  return {std::floor(y_map / spacing_m), std::floor(x_map / spacing_m)};
}

std::vector<Obstacle> obstacles_in(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o,
    const std::vector<Passage>& cells)
{
  const SurfaceView view(map);
  const int n = view.window.cells;
  const double yaw_rad = yaw_of(T_map_base), c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  std::vector<Obstacle> found;
  for (int iy = 0; iy < n; iy++)
    for (int ix = 0; ix < n; ix++)
    {
      const std::size_t cell = view.index(ix, iy);
      if (cells[cell] != Passage::Obstacle) continue;
      const double dx = view.x_m(ix) - T_map_base.x(), dy = view.y_m(iy) - T_map_base.y();
      if (dx * dx + dy * dy > o.range_m * o.range_m) continue;
      if (o.boundary_only && !on_boundary(cells, n, ix, iy)) continue;
      const double above = view.top(cell) - view.ground[cell];  // NaN where unknown
      const auto square =
          o.spacing_m > 0 ? square_of(view.x_m(ix), view.y_m(iy), o.spacing_m) : Square{};
      found.push_back({c * dx + s * dy, -s * dx + c * dy, above > 0 ? above : 0.0, square});
    }
  return found;
}

/** The nearest one of each square. */
void keep_nearest(std::vector<Obstacle>& obstacles)
{
  const auto range2 = [](const Obstacle& p) { return p.x_m * p.x_m + p.y_m * p.y_m; };
  std::sort(
      obstacles.begin(), obstacles.end(),
      [&](const Obstacle& a, const Obstacle& b)
      { return a.square != b.square ? a.square < b.square : range2(a) < range2(b); });
  const auto last = std::unique(
      obstacles.begin(), obstacles.end(),
      [](const Obstacle& a, const Obstacle& b) { return a.square == b.square; });
  obstacles.erase(last, obstacles.end());
}

/** Appends what is higher than `above_m` at the height z. */
void add_points(
    std::vector<Obstacle> obstacles, double above_m, double z_m, const ObstacleOptions& o,
    std::vector<ObstaclePoint>& out)
{
  const auto lower = std::remove_if(
      obstacles.begin(), obstacles.end(), [&](const auto& p) { return p.height_m < above_m; });
  obstacles.erase(lower, obstacles.end());
  if (o.spacing_m > 0) keep_nearest(obstacles);
  for (const auto& p : obstacles)
    out.push_back({static_cast<float>(p.x_m), static_cast<float>(p.y_m), static_cast<float>(z_m)});
}
}  // namespace

std::vector<ObstaclePoint> find_obstacles(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o,
    const std::vector<Passage>& cells, const std::vector<double>& prism_heights_m)
{
  std::vector<ObstaclePoint> out;
  if (map.empty()) return out;
  const auto obstacles = obstacles_in(map, T_map_base, o, cells);
  if (prism_heights_m.empty()) add_points(obstacles, 0, o.z_m, o, out);
  double bottom = 0;
  for (const double height : prism_heights_m)
  {
    add_points(obstacles, bottom, bottom + height / 2, o, out);
    bottom += height;
  }
  return out;
}

}  // namespace talus::nav
