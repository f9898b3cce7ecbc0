#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/observation_points.h>
#include <talus/nav/costmap.h>
#include <talus/number_text.h>

#include <cmath>
#include <stdexcept>

namespace talus
{
namespace
{
using mrpt::maps::COccupancyGridMap2D;

constexpr double kMaxShift_cells = 0.01;  // between the borders of costmap and map

bool is_whole(double cells) { return std::abs(cells - std::round(cells)) <= kMaxShift_cells; }

/** Whether `cells` from `first` on, which may be far away, reach into a grid. */
bool overlap(double first, int cells, std::size_t grid_cells)
{
  return first > -cells && first < static_cast<double>(grid_cells);
}

/** Cell (0, 0) of the window in a costmap; it may be far away. */
struct Place
{
  double x, y;
};

/** Throws std::invalid_argument where the cells of both do not match. */
Place place_in(const COccupancyGridMap2D& grid, const Window& w)
{
  const Place first{
      (w.min_x_m() - grid.getXMin()) / w.resolution_m,
      (w.min_y_m() - grid.getYMin()) / w.resolution_m};
  const bool same_size = std::abs(grid.getResolution() - w.resolution_m) < 1e-6;
  if (!same_size || !is_whole(first.x) || !is_whole(first.y))
    throw std::invalid_argument(
        "the costmap must have the cells of the map: the same resolution, and borders at whole "
        "multiples of it");
  return first;
}

/** f(cell of the window, its column and row in the costmap); what lies outside of the costmap is
 * ignored by MRPT. */
template <class F>
void for_each_shared(const Window& w, const Place& first, const COccupancyGridMap2D& grid, F f)
{
  if (!overlap(first.x, w.cells, grid.getSizeX()) || !overlap(first.y, w.cells, grid.getSizeY()))
    return;
  const int x0 = static_cast<int>(std::lround(first.x)),
            y0 = static_cast<int>(std::lround(first.y));
  for (int iy = 0; iy < w.cells; iy++)
    for (int ix = 0; ix < w.cells; ix++)
      f(static_cast<std::size_t>(iy * w.cells + ix), x0 + ix, y0 + iy);
}

/** MRPT keeps the borders of a grid as floats. */
void require_exact_borders(const Window& w)
{
  for (const double border_m : {w.min_x_m(), w.min_y_m()})
    if (std::abs(static_cast<float>(border_m) - border_m) > kMaxShift_cells * w.resolution_m)
      throw std::invalid_argument(
          "no costmap with cells of " + number_text(w.resolution_m, 6) + " m can lie at (" +
          fixed_text(w.min_x_m(), 1) + ", " + fixed_text(w.min_y_m(), 1) +
          ") m, so far from the origin: MRPT keeps its borders as floats; choose a map frame whose "
          "origin is near");
}
}  // namespace

void update_costmap(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const nav::ObstacleOptions& o,
    COccupancyGridMap2D& grid)
{
  const Place first = place_in(grid, map.window());
  const auto now = nav::free_probabilities(map, pose_from(T_map_base), o);
  for_each_shared(
      map.window(), first, grid,
      [&](std::size_t i, int x, int y)
      { grid.setCell(x, y, nav::updated(grid.getCell(x, y), now[i])); });
}

void admit_doubtful(COccupancyGridMap2D& grid)
{
  for (int y = 0; y < static_cast<int>(grid.getSizeY()); y++)
    for (int x = 0; x < static_cast<int>(grid.getSizeX()); x++)
      grid.setCell(x, y, nav::admitted(grid.getCell(x, y)));
}

void costmap_from_map(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const nav::ObstacleOptions& o,
    COccupancyGridMap2D& out)
{
  const Window w = map.window();
  require_exact_borders(w);
  const double side_m = w.cells * w.resolution_m;
  out.setSize(
      static_cast<float>(w.min_x_m()), static_cast<float>(w.min_x_m() + side_m),
      static_cast<float>(w.min_y_m()), static_cast<float>(w.min_y_m() + side_m),
      static_cast<float>(w.resolution_m), nav::kHopeful);
  update_costmap(map, T_map_base, o, out);
}

void CDualElevationMap::getAsOccupancyGrid(
    COccupancyGridMap2D& out, const ObstacleOptions& options) const
{
  costmap_from_map(view(), m_T_map_base, options, out);
}

}  // namespace talus
