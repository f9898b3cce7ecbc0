#include "to_goal.h"

#include "footprints.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr double kRoom_m = 0.6;  // between the middle of the robot and what blocks
// Times its length a way costs where the robot hardly fits. The margin of an edge is room already.
constexpr double kDearestBesideWall = 2.5, kDearestBesideEdge = 1.3;
constexpr double kBesideGoal = 4;  // mm cost as much as one to the goal

constexpr std::size_t kBuckets = 1024;  // more than the dearest step from cell to cell costs
}  // namespace

ToGoal::ToGoal(
    const PlanningGrid& grid, const Point2& goal, double arrives_m, double half_width_m,
    const Point2& from)
    : grid_(grid),
      from_(grid.index(grid.column_of(from.x_m), grid.row_of(from.y_m))),
      factor_(grid.size(), 0),
      cost_(grid.size(), kNoWay)
{
  rate(half_width_m);
  open_around(from);
  add_goals(goal, arrives_m);
  spread();
}

void ToGoal::rate(double half_width_m)
{
  const double third_m = grid_.cell_m() / PlanningGrid::kThirds;
  const double closer_m = kMargins.edge_m - kMargins.standing_m;
  const double least_m = half_width_m + kMargins.standing_m;
  std::array<std::uint8_t, PlanningGrid::kFarthest_thirds + 1> standing{}, edge{};
  const auto factor = [&](double away_m, double dearest)
  {
    if (PlanningGrid::kTooLong * away_m < least_m) return 0.0;
    const double lacks = std::clamp((kRoom_m - away_m) / (kRoom_m - least_m), 0.0, 1.0);
    return kPlain * (1 + (dearest - 1) * lacks * lacks);
  };
  for (std::size_t d = 0; d < standing.size(); d++)
  {
    const double away_m = static_cast<double>(d) * third_m;
    standing[d] = static_cast<std::uint8_t>(factor(away_m, kDearestBesideWall));
    edge[d] = static_cast<std::uint8_t>(factor(away_m - closer_m, kDearestBesideEdge));
  }
  for (int y = 0; y < grid_.rows(); y++)
    for (int x = 0; x < grid_.columns(); x++)
    {
      if (!grid_.contains(x, y)) continue;
      const std::size_t cell = grid_.index(x, y);
      const auto a = standing[static_cast<std::size_t>(grid_.to_standing_thirds(cell))];
      const auto b = edge[static_cast<std::size_t>(grid_.to_edge_thirds(cell))];
      factor_[cell] = a == 0 || b == 0 ? std::uint8_t{0} : std::max(a, b);
    }
}

void ToGoal::open_around(const Point2& from)
{
  const auto reach = static_cast<int>(std::lround(kNearStart_m / grid_.cell_m()));
  const int column = grid_.column_of(from.x_m), row = grid_.row_of(from.y_m);
  for (int y = row - reach; y <= row + reach; y++)
    for (int x = column - reach; x <= column + reach; x++)
    {
      if (!grid_.contains(x, y) || grid_.ground(grid_.index(x, y)) != Ground::Free) continue;
      auto& factor = factor_[grid_.index(x, y)];
      if (factor == 0) factor = static_cast<std::uint8_t>(kDearestBesideWall * kPlain);
    }
}

void ToGoal::add_goals(const Point2& goal, double arrives_m)
{
  for (int y = grid_.row_of(goal.y_m - arrives_m); y <= grid_.row_of(goal.y_m + arrives_m); y++)
    for (int x = grid_.column_of(goal.x_m - arrives_m); x <= grid_.column_of(goal.x_m + arrives_m);
         x++)
    {
      if (!grid_.contains(x, y) || is_blocked(grid_.index(x, y))) continue;
      const double away_m = std::hypot(grid_.x_m(x) - goal.x_m, grid_.y_m(y) - goal.y_m);
      if (away_m <= arrives_m)
        goals_.emplace_back(grid_.index(x, y), static_cast<int>(1000 * kBesideGoal * away_m));
    }
}

int ToGoal::end_cost_mm(std::size_t cell) const
{
  if (goals_.empty() || cost_[cell] > goals_.back().second) return kNoWay;
  const auto at = std::find_if(
      goals_.begin(), goals_.end(), [cell](const auto& goal) { return goal.first == cell; });
  return at == goals_.end() ? kNoWay : at->second;
}

/** Dijkstra's search, with a bucket for each cost. It ends at the cell that is asked for. */
void ToGoal::spread()
{
  std::array<std::vector<std::size_t>, kBuckets> buckets;
  auto goal = goals_.begin();
  std::sort(
      goals_.begin(), goals_.end(),
      [](const auto& a, const auto& b) { return a.second < b.second; });
  const int straight_mm = static_cast<int>(std::lround(1000 * grid_.cell_m()));
  const int diagonal_mm = static_cast<int>(std::lround(1000 * std::sqrt(2.0) * grid_.cell_m()));
  std::size_t waiting = 0;
  const auto offer = [&](std::size_t cell, int cost)
  {
    if (is_blocked(cell) || cost >= cost_[cell]) return;
    cost_[cell] = cost;
    buckets[static_cast<std::size_t>(cost) % kBuckets].push_back(cell);
    waiting++;
  };
  const int n = grid_.columns();
  for (; waiting > 0 || goal != goals_.end(); reached_++)
  {
    for (; goal != goals_.end() && goal->second <= reached_; ++goal)
      offer(goal->first, goal->second);
    auto& now = buckets[static_cast<std::size_t>(reached_) % kBuckets];
    for (std::size_t i = 0; i < now.size(); i++)
    {
      const std::size_t cell = now[i];
      if (cost_[cell] != reached_) continue;
      if (cell == from_) return;
      for (const int to : {-1, 1, -n, n})
        offer(cell + static_cast<std::size_t>(to), reached_ + step_mm(cell, straight_mm));
      for (const int to : {-n - 1, -n + 1, n - 1, n + 1})
        offer(cell + static_cast<std::size_t>(to), reached_ + step_mm(cell, diagonal_mm));
    }
    waiting -= now.size();
    now.clear();
  }
  found_all_ = true;
}

}  // namespace talus::nav
