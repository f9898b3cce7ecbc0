#include "footprints.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus::nav
{
namespace
{
constexpr double kTurn_rad = 2 * M_PI;

double middle_rad(int half_heading)
{
  const int h = half_heading / 2;
  if (half_heading % 2 == 0) return heading_rad(h);
  const double next_rad = h + 1 == kHeadings ? kTurn_rad : heading_rad(h + 1);
  return (heading_rad(h) + next_rad) / 2;
}
}  // namespace

double heading_rad(int heading)
{
  static const auto headings_rad = []
  {
    std::array<double, kHeadings> out{};
    for (std::size_t h = 0; h < out.size(); h++)
    {
      const double yaw_rad = std::atan2(kSteps[h].rows, kSteps[h].columns);
      out[h] = yaw_rad < 0 ? yaw_rad + kTurn_rad : yaw_rad;
    }
    return out;
  }();
  return headings_rad[static_cast<std::size_t>(heading)];
}

int heading_of(double yaw_rad)
{
  const auto off = [yaw_rad](int h)
  { return std::abs(std::remainder(heading_rad(h) - yaw_rad, kTurn_rad)); };
  const double turn = yaw_rad / kTurn_rad;
  const int about = static_cast<int>(std::lround((turn - std::floor(turn)) * kHeadings));
  int nearest = about % kHeadings;
  for (const int h : {(about + 1) % kHeadings, (about + kHeadings - 1) % kHeadings})
    if (off(h) < off(nearest)) nearest = h;
  return nearest;
}

Footprints::Footprints(const Footprint& robot, double cell_m, const Margins& margins)
{
  const double corner_m = robot.reach_m();
  const double farthest_m = std::max(margins.standing_m, margins.edge_m);
  if (!((corner_m + farthest_m) / cell_m <= PlanningGrid::kBorder_cells - 1))
    throw std::invalid_argument("the robot is too large for a lattice with such small cells");
  const auto sure_thirds = [&](double margin_m)
  {
    const double cells = (corner_m + margin_m) / cell_m;
    return static_cast<int>(std::ceil(PlanningGrid::kTooLong * PlanningGrid::kThirds * cells)) + 1;
  };
  sure_standing_thirds_ = sure_thirds(margins.standing_m);
  sure_edge_thirds_ = sure_thirds(margins.edge_m);
  const int reach = static_cast<int>(std::ceil((corner_m + farthest_m) / cell_m));
  for (std::size_t h = 0; h < cells_.size(); h++)
  {
    const double yaw_rad = middle_rad(static_cast<int>(h));
    const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
    for (int y = -reach; y <= reach; y++)
      for (int x = -reach; x <= reach; x++)
      {
        const double away_m =
            robot.outside_m({cell_m * (c * x + s * y), cell_m * (-s * x + c * y)});
        if (away_m <= margins.standing_m)
          cells_[h].all.push_back({x, y});
        else if (away_m <= margins.edge_m)
          cells_[h].edge.push_back({x, y});
      }
  }
}

bool Footprints::is_sure(const PlanningGrid& grid, std::size_t cell) const
{
  return grid.to_standing_thirds(cell) >= sure_standing_thirds_ &&
         grid.to_edge_thirds(cell) >= sure_edge_thirds_;
}

bool Footprints::fits(const PlanningGrid& grid, std::size_t cell, int half_heading) const
{
  if (is_sure(grid, cell)) return true;
  const Cells& covered = cells_[static_cast<std::size_t>(half_heading)];
  const int column = grid.column(cell), row = grid.row(cell);
  const auto ground_at = [&](const HeadingStep& to)
  { return grid.ground(grid.index(column + to.columns, row + to.rows)); };
  return std::all_of(
             covered.all.begin(), covered.all.end(),
             [&](const HeadingStep& to) { return ground_at(to) == Ground::Free; }) &&
         std::all_of(
             covered.edge.begin(), covered.edge.end(),
             [&](const HeadingStep& to) { return ground_at(to) != Ground::Edge; });
}

}  // namespace talus::nav
