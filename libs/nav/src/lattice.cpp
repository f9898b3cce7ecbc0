#include "lattice.h"

#include "to_goal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <utility>

namespace talus::nav
{
namespace
{
constexpr std::array<double, 5> kShares{1, 0.75, 0.5, 0.25, 0};  // of the margins
constexpr double kEdgeShare = 0.75;  // at least, away from the start: 10 cm and half a cell
constexpr Margins kRoom{0.15, 0.15};  // what the reactive navigator needs
constexpr int kTurn_mm = 60;  // of way cost as much as a turn by one heading
constexpr int kBackwards = 3;  // times as much as forwards
constexpr int kOffStart = 2;  // times the distance costs a start beside the robot
/** A way is dearer from this cost of the ground on, and the more the nearer it is to 1. So slopes
 * are cheapest straight. Less lies within the noise, and is not worth a detour. */
constexpr double kCheapGround = 0.3, kDearGround = 3;
constexpr double kTilted = 0.35;  // from this cost on the heading matters
constexpr double kForgets_m = 0.8;  // so near what does not block was seen
constexpr std::size_t kMaxStates = 100000;  // that are looked at

/** A cell and a heading. */
using State = std::uint64_t;
State state_of(std::size_t cell, int heading)
{
  return cell * kHeadings + static_cast<State>(heading);
}
std::size_t cell_of(State s) { return s / kHeadings; }
int heading_in(State s) { return static_cast<int>(s % kHeadings); }

/** What the search knows of the headings of a cell. */
struct Node
{
  std::array<std::int32_t, kHeadings> cost_mm;
  std::array<State, kHeadings> from;
  std::uint32_t asked = 0, fits = 0;  //!< bits of half headings
  /** What a way costs more there, in hundredths of it. */
  std::array<std::int16_t, kHeadings> ground_percent;
};
constexpr std::int16_t kNotAsked = -1, kImpassable = 32767;

class Search
{
 public:
  Search(
      const PlanningGrid& grid, const ToGoal& to_goal, const Footprints& near_start,
      const Footprints& elsewhere, const GroundCostAt& ground_cost, const Pose2& robot)
      : grid_(grid),
        to_goal_(to_goal),
        near_start_(near_start),
        elsewhere_(elsewhere),
        ground_cost_(ground_cost),
        node_of_(grid.size(), -1),
        robot_(robot)
  {
    start();
  }

  /** Whether it came away from the start. */
  bool left_start() const { return left_start_; }
  /** Whether the robot fits where it is. */
  bool has_start() const { return !queue_.empty(); }

  /** The states from start to goal; none where there is no way. */
  std::vector<State> run()
  {
    while (!queue_.empty() && looked_at_ < kMaxStates)
    {
      const Offer best = queue_.top();
      queue_.pop();
      if (best.state == kGoal) return way_to(end_);
      const int cost_mm = node(cell_of(best.state)).cost_mm[index(best.state)];
      if (best.cost_mm > cost_mm) continue;  // a better way was found since
      looked_at_++;
      left_start_ = left_start_ || !is_near_start(cell_of(best.state));
      look_at(best.state, cost_mm);
    }
    return {};
  }

 private:
  static constexpr State kGoal = ~State{0};
  struct Offer
  {
    int total_mm, cost_mm;
    State state;
    bool operator<(const Offer& o) const
    {
      return total_mm != o.total_mm ? total_mm > o.total_mm : state > o.state;
    }
  };
  static std::size_t index(State s) { return static_cast<std::size_t>(heading_in(s)); }

  Node& node(std::size_t cell)
  {
    if (node_of_[cell] < 0)
    {
      node_of_[cell] = static_cast<std::int32_t>(nodes_.size());
      nodes_.emplace_back();
      nodes_.back().cost_mm.fill(ToGoal::kNoWay);
      nodes_.back().ground_percent.fill(kNotAsked);
    }
    return nodes_[static_cast<std::size_t>(node_of_[cell])];
  }

  bool fits(std::size_t cell, int half_heading)
  {
    Node& n = node(cell);
    const std::uint32_t bit = std::uint32_t{1} << half_heading;
    if (!(n.asked & bit))
    {
      n.asked |= bit;
      const Footprints& footprints = is_near_start(cell) ? near_start_ : elsewhere_;
      if (footprints.fits(grid_, cell, half_heading)) n.fits |= bit;
    }
    return n.fits & bit;
  }

  bool is_near_start(std::size_t cell) const { return away_m(cell) < kNearStart_m; }
  double away_m(std::size_t cell) const
  {
    return std::hypot(
        grid_.x_m(grid_.column(cell)) - robot_.x_m, grid_.y_m(grid_.row(cell)) - robot_.y_m);
  }

  /** Of a move of this length to a pose, beside what blocks and on uneven ground; kNoWay where the
   * robot must not stand. */
  int move_mm(std::size_t to_cell, int to_heading, int length_mm)
  {
    const int percent = ground_percent(to_cell, to_heading);
    if (percent == kImpassable) return ToGoal::kNoWay;
    return to_goal_.step_mm(to_cell, length_mm) * (100 + percent) / 100;
  }

  int ground_percent(std::size_t cell, int heading)
  {
    std::int16_t& percent = node(cell).ground_percent[static_cast<std::size_t>(heading)];
    if (percent != kNotAsked) return percent;
    const double cost = ground_cost_(
        {grid_.x_m(grid_.column(cell)), grid_.y_m(grid_.row(cell)), heading_rad(heading)});
    const double dear = kDearGround * (cost * cost - kCheapGround * kCheapGround);
    // A robot that stands badly must get away.
    const bool impassable = cost >= 1 && !is_near_start(cell);
    percent = impassable ? kImpassable : static_cast<std::int16_t>(dear > 0 ? 100 * dear : 0);
    return percent;
  }

  /** From the states around the robot. */
  void start()
  {
    const int column = grid_.column_of(robot_.x_m), row = grid_.row_of(robot_.y_m);
    const int heading = heading_of(robot_.yaw_rad);
    for (int y = row - 1; y <= row + 1; y++)
      for (int x = column - 1; x <= column + 1; x++)
        for (int h = heading - 1; h <= heading + 1; h++)
          start_at(grid_.index(x, y), (h + kHeadings) % kHeadings);
  }

  void start_at(std::size_t cell, int heading)
  {
    if (!fits(cell, 2 * heading)) return;
    const double off_rad =
        std::abs(std::remainder(heading_rad(heading) - robot_.yaw_rad, 2 * M_PI));
    const double turns = off_rad / (2 * M_PI / kHeadings);
    const double off_mm = kOffStart * 1000 * away_m(cell) + kTurn_mm * turns;
    offer(state_of(cell, heading), kGoal, static_cast<int>(off_mm));
  }

  void offer(State state, State from, int cost_mm)
  {
    const std::size_t cell = cell_of(state);
    Node& n = node(cell);
    if (cost_mm >= n.cost_mm[index(state)]) return;
    n.cost_mm[index(state)] = cost_mm;
    n.from[index(state)] = from;
    queue_.push({cost_mm + to_goal_.cost_mm(cell), cost_mm, state});
  }

  void look_at(State state, int cost_mm)
  {
    const std::size_t cell = cell_of(state);
    const int heading = heading_in(state), end_mm = to_goal_.end_cost_mm(cell);
    if (end_mm < ToGoal::kNoWay && cost_mm + end_mm < goal_mm_)
    {
      goal_mm_ = cost_mm + end_mm;
      end_ = state;
      queue_.push({goal_mm_, goal_mm_, kGoal});
    }
    for (const int sign : {1, -1}) step(state, cost_mm, sign);
    for (const int turn : {1, kHeadings - 1})
    {
      const int to = (heading + turn) % kHeadings;
      const int between = (2 * heading + (turn == 1 ? 1 : 2 * kHeadings - 1)) % (2 * kHeadings);
      if (!fits(cell, between) || !fits(cell, 2 * to)) continue;
      const int move = move_mm(cell, to, kTurn_mm);
      if (move < ToGoal::kNoWay) offer(state_of(cell, to), state, cost_mm + move);
    }
  }

  void step(State state, int cost_mm, int sign)
  {
    const std::size_t from = cell_of(state);
    const int heading = heading_in(state);
    const HeadingStep& by = kSteps[static_cast<std::size_t>(heading)];
    const int column = grid_.column(from) + sign * by.columns;
    const int row = grid_.row(from) + sign * by.rows;
    if (!grid_.contains(column, row)) return;
    const std::size_t to = grid_.index(column, row);
    if (to_goal_.cost_mm(to) >= ToGoal::kNoWay) return;
    if (!fits(to, 2 * heading)) return;
    const int length_mm =
        static_cast<int>(std::lround(1000 * grid_.cell_m() * std::hypot(by.columns, by.rows)));
    const int move = move_mm(to, heading, length_mm);
    if (move == ToGoal::kNoWay) return;
    offer(state_of(to, heading), state, cost_mm + (sign > 0 ? move : kBackwards * move));
  }

  std::vector<State> way_to(State end)
  {
    std::vector<State> way;
    for (State s = end; s != kGoal; s = node(cell_of(s)).from[index(s)]) way.push_back(s);
    std::reverse(way.begin(), way.end());
    return way;
  }

  const PlanningGrid& grid_;
  const ToGoal& to_goal_;
  const Footprints &near_start_, &elsewhere_;
  const GroundCostAt& ground_cost_;
  std::vector<std::int32_t> node_of_;  //!< of each cell; -1: none yet
  std::vector<Node> nodes_;
  std::priority_queue<Offer> queue_;
  Pose2 robot_;
  std::size_t looked_at_ = 0;
  bool left_start_ = false;
  int goal_mm_ = ToGoal::kNoWay;
  State end_ = kGoal;
};

std::vector<Footprints> shares_of(const Footprint& robot, double cell_m, double min_edge_share)
{
  std::vector<Footprints> out;
  out.reserve(kShares.size());
  for (const double share : kShares)
    out.emplace_back(
        robot, cell_m,
        Margins{share * kMargins.standing_m, std::max(share, min_edge_share) * kMargins.edge_m});
  return out;
}

/** With as much of the margins as there is where the robot stands, or as little as it needs to get
 * away from there, as where it turns between walls, and all elsewhere; and where it cannot get away
 * from what it is near to, as along a wall, with no more than that. */
std::vector<State> find_states(
    const PlanningGrid& grid, const ToGoal& to_goal, const std::vector<Footprints>& near_start,
    const std::vector<Footprints>& elsewhere, const GroundCostAt& ground_cost, const Pose2& robot)
{
  for (std::size_t i = 0; i < near_start.size(); i++)
  {
    Search search(grid, to_goal, near_start[i], elsewhere.front(), ground_cost, robot);
    if (!search.has_start()) continue;
    auto states = search.run();
    if (!states.empty()) return states;
    if (!search.left_start() && i + 1 < near_start.size()) continue;
    const Footprints& closer = elsewhere[std::max<std::size_t>(i, 1)];
    return Search(grid, to_goal, near_start[i], closer, ground_cost, robot).run();
  }
  return {};
}

bool leads_back(const RoutePose& a, const RoutePose& b)
{
  return (b.x_m - a.x_m) * std::cos(a.yaw_rad) + (b.y_m - a.y_m) * std::sin(a.yaw_rad) < 0;
}
}  // namespace

Lattice::Lattice(const Footprint& robot, double cell_m)
    : robot_(robot),
      near_start_(shares_of(robot, cell_m, 0)),
      elsewhere_(shares_of(robot, cell_m, kEdgeShare)),
      with_room_(robot, cell_m, kRoom)
{
}

Route Lattice::plan(
    const Costmap& costmap, double around_m, const Pose2& robot, const Point2& goal,
    double arrives_m, const GroundCostAt& ground_cost) const
{
  PlanningGrid grid(costmap, around_m);
  const int column = grid.column_of(robot.x_m), row = grid.row_of(robot.y_m);
  if (!grid.contains(column, row)) return {};
  grid.clear(robot, robot_);
  grid.measure();
  const double half_width_m =
      std::min({robot_.max_x_m, -robot_.min_x_m, robot_.max_y_m, -robot_.min_y_m});
  const ToGoal to_goal(grid, goal, arrives_m, half_width_m, {robot.x_m, robot.y_m});
  if (!to_goal.found()) return {};
  Route route;
  for (const State s : find_states(grid, to_goal, near_start_, elsewhere_, ground_cost, robot))
  {
    const std::size_t cell = cell_of(s);
    const int heading = heading_in(s);
    const Pose2 pose{grid.x_m(grid.column(cell)), grid.y_m(grid.row(cell)), heading_rad(heading)};
    route.push_back(
        {pose.x_m, pose.y_m, pose.yaw_rad, false, !with_room_.fits(grid, cell, 2 * heading),
         ground_cost(pose) >= kTilted});
    if (route.size() > 1)
      route.back().backwards = leads_back(route[route.size() - 2], route.back());
  }
  return route;
}

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
