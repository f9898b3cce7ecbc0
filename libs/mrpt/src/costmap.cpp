#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>

#include <cmath>
#include <stdexcept>

namespace talus
{
namespace
{
using mrpt::maps::COccupancyGridMap2D;

constexpr float kObstacle = 0.05F;  // probability of being free

float free_probability(float traversability)
{
  return 0.55F + (traversability > 0 ? 0.4F * traversability : 0.0F);  // NaN below the robot
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
  if (!same_size || std::abs(first_x - std::round(first_x)) > 0.01 ||
      std::abs(first_y - std::round(first_y)) > 0.01)
    throw std::invalid_argument(
        "the costmap must have the cells of the map: the same resolution, and borders at whole "
        "multiples of it");
  const auto cells = classify_cells(map, T_map_base, o);
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
  costmap_from_map(mapper(), m_T_map_base, options, out);
}

}  // namespace talus
