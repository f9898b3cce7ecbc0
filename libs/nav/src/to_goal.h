#pragma once
#include "planning_grid.h"

#include <cstdint>
#include <vector>

namespace talus::nav
{
/** The cost of a way for the middle of a robot, whatever its heading: its length in millimetres,
 * and more beside what blocks. A lower bound where nobody asked yet. */
class ToGoal
{
 public:
  static constexpr int kNoWay = 1 << 30;

  /** From all cells within `arrives_m` of the goal, best from the goal itself. `half_width_m`: of
   * the robot. Ways are found up to the cell from which they are asked for; margins count, but
   * near the robot, which must find away from what it is near to. */
  ToGoal(
      const PlanningGrid& grid, const Point2& goal, double arrives_m, double half_width_m,
      const Point2& from);

  bool found() const { return cost_[from_] < kNoWay; }
  /** Of the way from a cell. */
  int cost_mm(std::size_t cell) const
  {
    return cost_[cell] <= reached_ || is_blocked(cell) || found_all_ ? cost_[cell] : reached_;
  }
  /** From a place that is near enough to the goal; kNoWay elsewhere. */
  int end_cost_mm(std::size_t cell) const;
  bool is_blocked(std::size_t cell) const { return factor_[cell] == 0; }
  /** Of a way of this length from a cell. */
  int step_mm(std::size_t cell, int length_mm) const { return length_mm * factor_[cell] / kPlain; }

 private:
  static constexpr int kPlain = 16;  //!< the factor of a place with room around

  void rate(double half_width_m);
  void open_around(const Point2& from);
  void add_goals(const Point2& goal, double arrives_m);
  void spread();

  const PlanningGrid& grid_;
  std::size_t from_;
  std::vector<std::uint8_t> factor_;  //!< of costs, sixteenths; 0: blocked
  std::vector<std::pair<std::size_t, int>> goals_;  //!< with what they cost
  std::vector<std::int32_t> cost_;
  int reached_ = 0;  //!< all that costs less was found
  bool found_all_ = false;
};

}  // namespace talus::nav
