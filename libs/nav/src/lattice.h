#pragma once
#include <talus/nav/route.h>

#include <cstdint>
#include <set>
#include <utility>
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

/** Remembers what blocked because it was not seen from nearby. From farther away it blocks no more,
 * and a robot without this memory turns back to it again and again. */
class UnseenCells
{
 public:
  /** `costmap` and the same one with more blocked, because it must have been seen by now. */
  void remember(const Pose2& robot, const Costmap& costmap, const Costmap& blocked);
  /** Blocks it on a costmap; false where nothing is left to block. */
  bool block(Costmap& costmap) const;

 private:
  /** Column and row, counted from the origin of the map. */
  std::set<std::pair<std::int64_t, std::int64_t>> cells_;
};

}  // namespace talus::nav
