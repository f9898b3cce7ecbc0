#pragma once
#include <talus/nav/route.h>

#include <vector>

#include "footprints.h"

namespace talus::nav
{
/** Plans routes for a rectangular robot that turns on the spot, on a lattice of cells and 16
 * headings (A*). The same costmap gives the same route. */
class Lattice
{
 public:
  Lattice(const Footprint& robot, double cell_m);

  /** From the robot's pose to within `arrives_m` of the goal, best to the goal itself; `around_m`:
   * of unknown ground around the costmap. No pose where there is no way. */
  Route plan(
      const Costmap& costmap, double around_m, const Pose2& robot, const Point2& goal,
      double arrives_m, const GroundCostAt& ground_cost) const;

 private:
  Footprint robot_;
  /** Of the whole margins, and of less and less of them, for a robot that stands nearer to
   * something already; `elsewhere` with at least 10 cm to edges. */
  std::vector<Footprints> near_start_, elsewhere_;
  Footprints with_room_;
};

}  // namespace talus::nav
