#pragma once
#include "kernels/config.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"

namespace talus::kernels
{
/** The objects in a pair of cells; of its cells the last value here counts. A cell with recent hits
 * and without an object is one that an object left. */
enum Presence
{
  kEmpty,
  kLeft,  //!< an object stood in one cell, now in none
  kStands
};

/** Cells of the map pooled two by two, by the parity of their place in the map, so that rolling
 * does not change the pairs. Nothing is known in a margin around the window. */
struct CoarseGrid
{
  int side;  //!< coarse cells along each side, with both margins
  static constexpr int kMargin = 1;  //!< in coarse cells
  int pad;  //!< places beside each row that hold infinity
  float* lowest_m;  //!< lowest measured ground; infinity: none
  float* column_m;  //!< highest upright top; -infinity: none
  float* presence;  //!< a Presence
  float* eroded_m;  //!< lowest ground of the neighbourhood; infinity: near an upright object, or
                    //!< nothing is known there
  float* cone_m;  //!< lowest ground of the neighbourhood, raised with distance
  float* limit_m;  //!< highest that ground can be there

  TALUS_HD int at(int px, int py) const { return py * (side + 2 * pad) + px + pad; }
  /** Where a cell of the window is found, along one axis. */
  TALUS_HD int place_of(int cell, int odd) const { return ((cell + odd) >> 1) + kMargin; }
  /** The first cell of the pair at a place, along one axis; perhaps outside. */
  TALUS_HD int first_cell(int place, int odd) const { return 2 * (place - kMargin) - odd; }
};

TALUS_HD int dilation_radius(const Config& k) { return k.object_radius + kDilatesFarther_pairs; }
/** The most pairs that an object covers, which is narrower than ground. */
TALUS_HD int widest_thing(const Config& k) { return 2 * dilation_radius(k); }

TALUS_HD int coarse_side(const Config& k) { return k.cells / 2 + 1 + 2 * CoarseGrid::kMargin; }

}  // namespace talus::kernels
