#pragma once
#include "kernels/cell.h"
#include "kernels/config.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"

namespace talus::kernels
{
/** The objects in a pair of cells; of its cells the last value here counts. A cell with recent hits
 * and without an object is one from which an object moved away. */
enum Presence
{
  kEmpty,
  kLeft,  //!< an object stood in one cell, now in none
  kStands
};

/** Whether the robot gets to a pair of cells. */
enum Reach : std::int32_t
{
  kOutsideWindow = -1,
  kPairBlocked = 0,  //!< or not judged
  kPairPassable = 1,
  kPairReached = 2
};

/** Cells of the map pooled two by two, by the parity of their index in the map, so that rolling
 * does not change the pairs. Nothing is known in a margin around the window. */
struct PairGrid
{
  int side;  //!< pairs along each side, with both margins
  static constexpr int kMargin = 1;  //!< in pairs
  int pad;  //!< pairs beside each row that hold infinity

  TALUS_HD int at(int px, int py) const { return py * (side + 2 * pad) + px + pad; }
  /** The pair of a cell of the window, along one axis. */
  TALUS_HD int pair_at(int cell, int odd) const { return ((cell + odd) >> 1) + kMargin; }
  /** The first cell of a pair, along one axis; perhaps outside. */
  TALUS_HD int first_cell(int pair, int odd) const { return 2 * (pair - kMargin) - odd; }
};

TALUS_HD int dilation_radius(const Config& k) { return k.object_radius + kDilatesFarther_pairs; }
TALUS_HD PairGrid pair_grid(const Config& k)
{
  return {k.cells / 2 + 1 + 2 * PairGrid::kMargin, dilation_radius(k)};
}

}  // namespace talus::kernels
