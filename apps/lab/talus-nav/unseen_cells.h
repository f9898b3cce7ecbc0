#pragma once
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/math/TPose2D.h>

#include <set>
#include <utility>

namespace talus::nav
{
/** Remembers what blocked because it was not seen from nearby. From farther away it blocks no more,
 * and a robot without this memory turns back to it again and again. */
class UnseenCells
{
 public:
  /** `costmap` and the same one with more blocked, because it must have been seen by now. */
  void remember(
      const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap,
      const mrpt::maps::COccupancyGridMap2D& blocked);
  /** Blocks it on a costmap; false where nothing is left to block. */
  bool block(mrpt::maps::COccupancyGridMap2D& costmap) const;

 private:
  std::set<std::pair<int, int>> cells_;  //!< column and row, counted from the origin of the map
};

}  // namespace talus::nav
