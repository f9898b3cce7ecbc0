#include "unseen_cells.h"

#include <cmath>

namespace talus::nav
{
namespace
{
constexpr double kForgets_m = 0.8;  // so near what does not block was seen
}  // namespace

void UnseenCells::remember(const Pose2& robot, const Costmap& costmap, const Costmap& blocked)
{
  const double cell_m = costmap.resolution_m;
  for (int y = 0; y < costmap.rows; y++)
    for (int x = 0; x < costmap.columns; x++)
    {
      if (costmap.free[costmap.index(x, y)] <= kBlockedUpTo) continue;
      const std::pair cell{costmap.min_cell_x + x, costmap.min_cell_y + y};
      const double dx = (static_cast<double>(cell.first) + 0.5) * cell_m - robot.x_m;
      const double dy = (static_cast<double>(cell.second) + 0.5) * cell_m - robot.y_m;
      if (blocked.free[costmap.index(x, y)] <= kBlockedUpTo)
        cells_.insert(cell);
      else if (std::hypot(dx, dy) < kForgets_m)
        cells_.erase(cell);
    }
}

bool UnseenCells::block(Costmap& costmap) const
{
  bool any = false;
  for (const auto& [column, row] : cells_)
  {
    const std::size_t cell = costmap.index(
        static_cast<int>(column - costmap.min_cell_x), static_cast<int>(row - costmap.min_cell_y));
    if (costmap.free[cell] <= kBlockedUpTo) continue;
    costmap.free[cell] = kEdge;
    any = true;
  }
  return any;
}

}  // namespace talus::nav
