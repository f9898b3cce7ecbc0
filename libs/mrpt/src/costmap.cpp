#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>
#include <talus/number_text.h>

#include <cmath>
#include <stdexcept>

#include "surface_view.h"

namespace talus
{
namespace
{
using mrpt::maps::COccupancyGridMap2D;

// Probabilities of being free. What looks as if it drops from nearby, too, is not to be admitted.
constexpr float kObstacle = 0.05F, kDropsFromNearby = 0.1F, kEdge = 0.15F, kMayDrop = 0.2F;
constexpr float kMayDropBesideWall = 0.25F, kDropsFromNearbyBesideWall = 0.3F;
constexpr float kQuantised = 0.02F;  // by MRPT, at most
constexpr double kMaxShift_cells = 0.01;  // between the borders of costmap and map

float free_probability(float traversability)
{
  return 0.55F + (traversability > 0 ? 0.4F * traversability : 0.0F);  // NaN below the robot
}

bool is_about(float p, float wanted) { return std::abs(p - wanted) < kQuantised; }

bool may_drop(float p) { return is_about(p, kMayDrop) || is_about(p, kMayDropBesideWall); }

bool drops_from_nearby(float p)
{
  return is_about(p, kDropsFromNearby) || is_about(p, kDropsFromNearbyBesideWall);
}

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
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& o,
    COccupancyGridMap2D& grid)
{
  const Place first = place_in(grid, map.window());
  const auto judged = detail::judge_cells(map, T_map_base, o);
  const auto& cells = judged.passages;
  const auto& doubtful = judged.doubtful;
  const auto edges = find_edges(map, T_map_base, cells);
  const auto& traversability = map.layer(Layer::Traversability);
  for_each_shared(
      map.window(), first, grid,
      [&](std::size_t i, int x, int y)
      {
        if (cells[i] == Passage::Unknown && !doubtful[i]) return;
        if (cells[i] == Passage::Free)
          grid.setCell(x, y, free_probability(traversability[i]));
        else if (!doubtful[i])
          grid.setCell(x, y, edges[i] ? kEdge : kObstacle);
        else if (cells[i] == Passage::Obstacle)
          grid.setCell(x, y, edges[i] ? kDropsFromNearby : kDropsFromNearbyBesideWall);
        else if (!drops_from_nearby(grid.getCell(x, y)))
          grid.setCell(x, y, edges[i] ? kMayDrop : kMayDropBesideWall);
      });
}

void admit_doubtful(COccupancyGridMap2D& grid)
{
  for (int y = 0; y < static_cast<int>(grid.getSizeY()); y++)
    for (int x = 0; x < static_cast<int>(grid.getSizeX()); x++)
      if (may_drop(grid.getCell(x, y))) grid.setCell(x, y, free_probability(0));
}

void costmap_from_map(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& o,
    COccupancyGridMap2D& out)
{
  const Window w = map.window();
  require_exact_borders(w);
  const double side_m = w.cells * w.resolution_m;
  out.setSize(
      static_cast<float>(w.min_x_m()), static_cast<float>(w.min_x_m() + side_m),
      static_cast<float>(w.min_y_m()), static_cast<float>(w.min_y_m() + side_m),
      static_cast<float>(w.resolution_m), 0.5F);
  update_costmap(map, T_map_base, o, out);
}

void CDualElevationMap::getAsOccupancyGrid(
    COccupancyGridMap2D& out, const ObstacleOptions& options) const
{
  costmap_from_map(view(), m_T_map_base, options, out);
}

}  // namespace talus
