#include "unseen_cells.h"

#include "planning_grid.h"

#include <cmath>

namespace talus::nav
{
namespace
{
using mrpt::maps::COccupancyGridMap2D;

constexpr double kForgets_m = 0.8;  // so near what does not block was seen

std::pair<int, int> first_cell(const COccupancyGridMap2D& grid)
{
  const double cell_m = grid.getResolution();
  return {
      static_cast<int>(std::lround(grid.getXMin() / cell_m)),
      static_cast<int>(std::lround(grid.getYMin() / cell_m))};
}
}  // namespace

void UnseenCells::remember(
    const mrpt::math::TPose2D& robot, const COccupancyGridMap2D& costmap,
    const COccupancyGridMap2D& blocked)
{
  const auto [first_x, first_y] = first_cell(costmap);
  const double cell_m = costmap.getResolution();
  for (int y = 0; y < static_cast<int>(costmap.getSizeY()); y++)
    for (int x = 0; x < static_cast<int>(costmap.getSizeX()); x++)
    {
      if (costmap.getCell(x, y) <= kBlockedUpTo) continue;
      const std::pair cell{first_x + x, first_y + y};
      if (blocked.getCell(x, y) <= kBlockedUpTo)
        cells_.insert(cell);
      else if (
          std::hypot(
              (cell.first + 0.5) * cell_m - robot.x, (cell.second + 0.5) * cell_m - robot.y) <
          kForgets_m)
        cells_.erase(cell);
    }
}

bool UnseenCells::block(COccupancyGridMap2D& costmap) const
{
  const auto [first_x, first_y] = first_cell(costmap);
  bool any = false;
  for (const auto& [column, row] : cells_)
  {
    const int x = column - first_x, y = row - first_y;
    if (costmap.getCell(x, y) <= kBlockedUpTo) continue;
    costmap.setCell(x, y, kEdge);
    any = true;
  }
  return any;
}

}  // namespace talus::nav
