#pragma once
#include "footprints.h"

#include <mrpt/math/TPose2D.h>

#include <functional>
#include <vector>

namespace talus::nav
{
/** A place on a way of the robot. */
struct RoutePose
{
  double x_m, y_m, yaw_rad;
  bool backwards;  //!< it comes there in reverse
  bool narrow;  //!< there is no room for detours
  bool tilted;  //!< what the ground does with the robot depends on its heading
};

/** What the ground does with the robot at a pose, [0, 1]; 1: it must not stand there, NaN: that is
 * not known. */
using GroundCostAt = std::function<double(const mrpt::math::TPose2D&)>;

/** Plans ways for a rectangular robot that turns on the spot, on a lattice of cells and 16 headings
 * (A*). The same costmap gives the same way. */
class Lattice
{
 public:
  Lattice(double length_m, double width_m, double cell_m, GroundCostAt ground_cost);

  /** From the robot's pose to within `arrives_m` of the goal, best to the goal itself; `around_m`:
   * of unknown ground around the costmap. No pose where there is no way. */
  std::vector<RoutePose> plan(
      const mrpt::maps::COccupancyGridMap2D& costmap, double around_m,
      const mrpt::math::TPose2D& robot, const mrpt::math::TPoint2D& goal, double arrives_m) const;

 private:
  double length_m_, width_m_;
  GroundCostAt ground_cost_;
  /** Of the whole margins, and of less and less of them, for a robot that stands nearer to
   * something already; `elsewhere` with at least 10 cm to edges. */
  std::vector<Footprints> near_start_, elsewhere_;
  Footprints with_room_;
};

}  // namespace talus::nav
