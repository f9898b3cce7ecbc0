#pragma once
#include "planning_grid.h"

#include <array>
#include <vector>

namespace talus::nav
{
constexpr int kHeadings = 16;

/** A step of the lattice along a heading, in cells: from the middle of a cell to that of another.
 */
struct HeadingStep
{
  int columns, rows;
};
constexpr std::array<HeadingStep, kHeadings> kSteps{
    {{1, 0},
     {2, 1},
     {1, 1},
     {1, 2},
     {0, 1},
     {-1, 2},
     {-1, 1},
     {-2, 1},
     {-1, 0},
     {-2, -1},
     {-1, -1},
     {-1, -2},
     {0, -1},
     {1, -2},
     {1, -1},
     {2, -1}}};

double heading_rad(int heading);
/** The one nearest to a yaw. */
int heading_of(double yaw_rad);

/** What a robot keeps away: from the middle of cells in which something stands, and from that of
 * edges. This is the one place where its margins are. */
struct Margins
{
  double standing_m, edge_m;
};
/** Where there is room it keeps farther away, by the cost of a way. Beside an edge no part of its
 * shape comes nearer than 10 cm; 17 where there is a way, as the map knows edges to a cell or two.
 */
constexpr Margins kMargins{0.04, 0.17};
/** So near to where it is, less is enough for a robot that is nearer to something already. */
constexpr double kNearStart_m = 0.6;

/** The cells that a robot with margins covers, at each heading and between each two. */
class Footprints
{
 public:
  /** Throws std::invalid_argument for a robot that reaches over the border of a PlanningGrid. */
  Footprints(const Footprint& robot, double cell_m, const Margins& margins);

  /** At a heading, of 2 * kHeadings: the odd ones lie between two. */
  bool fits(const PlanningGrid& grid, std::size_t cell, int half_heading) const;

 private:
  struct Cells
  {
    std::vector<HeadingStep> all;  //!< in which nothing may block
    std::vector<HeadingStep> edge;  //!< in which no edge may be, either
  };
  bool is_sure(const PlanningGrid& grid, std::size_t cell) const;

  int sure_standing_thirds_, sure_edge_thirds_;  //!< as far away nothing can be in the way
  std::array<Cells, 2 * kHeadings> cells_;
};

}  // namespace talus::nav
