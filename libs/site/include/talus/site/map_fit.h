#pragma once
#include <talus/site/site.h>

#include <cmath>
#include <cstddef>

namespace talus::site
{
/** How two maps of one frame fit where both know the ground. Ground is compared where both have
 * measured it; what stands, where both have seen the place and one shows something. */
struct MapFit
{
  /** Which two, counted from 0 as they were given. */
  std::size_t first = 0, second = 0;
  /** What both know. */
  double overlap_m2 = 0;
  /** What is compared of it. */
  double ground_m2 = 0, standing_m2 = 0;
  /** How far the ground of the second lies above that of the first, median [m]; NaN where none is
   * compared. */
  double offset_z_m = NAN;
  /** [0, 1] of what is compared; 0 where nothing is. Grounds disagree that differ by more than
   * their noise and 3 cm; what stands disagrees where the other map shows nothing within a cell. */
  double ground_disagrees = 0, standing_disagrees = 0;

  /** False where the two do not lie in one frame, or one of them is wrong. Drives of different days
   * fit: what was built, dug or parked is a small part of an overlap. */
  bool fits() const;
};

/** Of a floor of two sites of one resolution. Throws as TileStore. */
MapFit fit_of(Site& first, Site& second, int floor);

}  // namespace talus::site
