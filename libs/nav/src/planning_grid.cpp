#include "planning_grid.h"

#include <algorithm>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr int kStraight = PlanningGrid::kThirds, kDiagonal = 4;
constexpr double kMaxShift_cells = 0.01;

Ground ground_of(float free_probability)
{
  if (free_probability > kBlockedUpTo) return Ground::Free;
  return free_probability < kStandsBelow || free_probability > kBesideAbove ? Ground::Stands
                                                                            : Ground::Edge;
}
/** Borders and cells are those of a costmap of MRPT, which are floats, where that shifts nothing:
 * of two routes that cost the same it is then the same one that is found. */
double as_float(double border_m, double cell_m)
{
  const double rounded_m = static_cast<float>(border_m);
  return std::abs(rounded_m - border_m) < kMaxShift_cells * cell_m ? rounded_m : border_m;
}
}  // namespace

PlanningGrid::PlanningGrid(const Costmap& costmap, double around_m)
    : cell_m_(static_cast<float>(costmap.resolution_m))
{
  const int around = kBorder_cells + static_cast<int>(std::ceil(around_m / cell_m_));
  columns_ = costmap.columns + 2 * around;
  rows_ = costmap.rows + 2 * around;
  min_x_m_ = as_float(costmap.min_x_m(), cell_m_) - around * cell_m_;
  min_y_m_ = as_float(costmap.min_y_m(), cell_m_) - around * cell_m_;
  ground_.assign(
      static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), Ground::Free);
  for (int y = 0; y < costmap.rows; y++)
    for (int x = 0; x < costmap.columns; x++)
      ground_[index(x + around, y + around)] = ground_of(costmap.free[costmap.index(x, y)]);
}

void PlanningGrid::clear(const Pose2& at, const Footprint& robot)
{
  const double reach_m = robot.reach_m();
  for (int y = row_of(at.y_m - reach_m); y <= row_of(at.y_m + reach_m); y++)
    for (int x = column_of(at.x_m - reach_m); x <= column_of(at.x_m + reach_m); x++)
    {
      if (x < 0 || y < 0 || x >= columns_ || y >= rows_) continue;
      if (robot.outside_m(at.to_robot({x_m(x), y_m(y)})) == 0) ground_[index(x, y)] = Ground::Free;
    }
}

void PlanningGrid::measure()
{
  to_standing_ = distances_to(Ground::Stands);
  to_edge_ = distances_to(Ground::Edge);
}

/** Once from the first cell to the last, and once back. */
std::vector<std::uint8_t> PlanningGrid::distances_to(Ground ground) const
{
  std::vector<std::uint8_t> out(ground_.size());
  for (std::size_t i = 0; i < out.size(); i++)
    out[i] = ground_[i] == ground ? 0 : static_cast<std::uint8_t>(kFarthest_thirds);
  const auto n = static_cast<std::size_t>(columns_);
  std::uint8_t* const at = out.data();
  const auto nearest =
      [at](std::size_t i, std::size_t beside, std::size_t a, std::size_t b, std::size_t c)
  {
    const int straight = std::min(at[beside], at[a]) + kStraight;
    const int diagonal = std::min(at[b], at[c]) + kDiagonal;
    at[i] = static_cast<std::uint8_t>(std::min({static_cast<int>(at[i]), straight, diagonal}));
  };
  const std::size_t first = n + 1, last = out.size() - n - 1;  // the border is free
  for (std::size_t i = first; i < last; i++) nearest(i, i - 1, i - n, i - n - 1, i - n + 1);
  for (std::size_t i = last; i-- > first;) nearest(i, i + 1, i + n, i + n + 1, i + n - 1);
  return out;
}

int PlanningGrid::column_of(double x_m) const
{
  return static_cast<int>(std::floor((x_m - min_x_m_) / cell_m_));
}

int PlanningGrid::row_of(double y_m) const
{
  return static_cast<int>(std::floor((y_m - min_y_m_) / cell_m_));
}

}  // namespace talus::nav
