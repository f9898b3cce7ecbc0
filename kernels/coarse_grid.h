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
 * does not change the pairs. In a margin around the window the ground goes on as at its border.
 * Without it the edge of a platform would be an object where only a strip of it is inside. */
struct CoarseGrid
{
  int side;  //!< coarse cells along each side, with both margins
  int margin;  //!< in coarse cells
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
  TALUS_HD int place_of(int cell, int odd) const { return ((cell + odd) >> 1) + margin; }
  /** The pair of cells whose ground a place has, along one axis: its own or that at the border. */
  TALUS_HD int pair_at(int place, int odd, int cells) const
  {
    return min_of(max_of(place - margin, 0), place_of(cells - 1, odd) - margin);
  }
};

TALUS_HD int coarse_margin(const Config& k) { return k.object_radius; }
TALUS_HD int dilation_radius(const Config& k) { return k.object_radius + kDilatesFarther_pairs; }
/** The most pairs that an object covers, which is narrower than ground. */
TALUS_HD int widest_thing(const Config& k) { return 2 * dilation_radius(k); }

TALUS_HD int coarse_side(const Config& k) { return k.cells / 2 + 1 + 2 * coarse_margin(k); }

}  // namespace talus::kernels
