#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>
#include <talus/number_text.h>

#include <cmath>
#include <stdexcept>

namespace talus
{
namespace
{
using mrpt::maps::COccupancyGridMap2D;

constexpr float kObstacle = 0.05F;  // probability of being free
constexpr double kMostShift_cells = 0.01;  // between the borders of costmap and map

float free_probability(float traversability)
{
  return 0.55F + (traversability > 0 ? 0.4F * traversability : 0.0F);  // NaN below the robot
}

bool is_whole(double cells) { return std::abs(cells - std::round(cells)) <= kMostShift_cells; }

/** Whether `cells` from `first` on, which may be far away, reach into a grid. */
bool overlap(double first, int cells, std::size_t grid_cells)
{
  return first > -cells && first < static_cast<double>(grid_cells);
}

/** MRPT keeps the borders of a grid as floats. */
void require_exact_borders(const Window& w)
{
  for (const double border_m : {w.min_x_m(), w.min_y_m()})
    if (std::abs(static_cast<float>(border_m) - border_m) > kMostShift_cells * w.resolution_m)
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
  const Window w = map.window();
  const double first_x = (w.min_x_m() - grid.getXMin()) / w.resolution_m;
  const double first_y = (w.min_y_m() - grid.getYMin()) / w.resolution_m;
  const bool same_size = std::abs(grid.getResolution() - w.resolution_m) < 1e-6;
  if (!same_size || !is_whole(first_x) || !is_whole(first_y))
    throw std::invalid_argument(
        "the costmap must have the cells of the map: the same resolution, and borders at whole "
        "multiples of it");
  const auto cells = classify_cells(map, T_map_base, o);
  if (!overlap(first_x, w.cells, grid.getSizeX()) || !overlap(first_y, w.cells, grid.getSizeY()))
    return;
  const auto& traversability = map.layer(Layer::Traversability);
  const int x0 = static_cast<int>(std::lround(first_x));
  const int y0 = static_cast<int>(std::lround(first_y));
  for (std::size_t i = 0; i < cells.size(); i++)
  {
    if (cells[i] == Passage::Unknown) continue;
    const int x = x0 + static_cast<int>(i) % w.cells, y = y0 + static_cast<int>(i) / w.cells;
    const float p = cells[i] == Passage::Obstacle ? kObstacle : free_probability(traversability[i]);
    grid.setCell(x, y, p);  // nothing happens outside of the grid
  }
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
