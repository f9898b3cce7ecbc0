#pragma once
#include "kernels/config.h"
#include "kernels/math.h"
#include "kernels/rule_switches.h"

namespace talus::kernels
{
/** What is known of things in a pair of cells: of its cells, the last of these. Where something was
 * hit lately and nothing stands it has left. */
enum Presence
{
  kEmpty,
  kLeft,  //!< something stood in one of them lately, nothing stands in any
  kStands
};

/** Cells of the map pooled two by two, by the parity of their place in the map, so that rolling
 * does not change the pairs. In a margin around the window the ground goes on as at its border, or
 * the edge of a platform of which only a strip is inside would be an object. */
struct CoarseGrid
{
  int side;  //!< coarse cells along each side, with both margins
  int margin;  //!< in coarse cells
  int pad;  //!< places beside each row that hold infinity
  float* lowest_m;  //!< lowest measured ground, infinity: none
  float* column_m;  //!< highest top of something upright, -infinity: none
  float* overhang_m;  //!< the same of what rays pass below, but not the robot ...
  float* overhang_depth_m;  //!< ... and how far down from it that is known to reach
  float* presence;  //!< a Presence
  float* eroded_m;  //!< lowest ground of the neighbourhood; infinity: near what is upright, or
                    //!< nothing is known there
  float* cone_m;  //!< lowest ground of the neighbourhood, raised with distance
  float* limit_m;  //!< how high ground stands there at most

  TALUS_HD int at(int px, int py) const { return py * (side + 2 * pad) + px + pad; }
  /** Along one axis: where a cell of the window is found. */
  TALUS_HD int place_of(int cell, int odd) const { return ((cell + odd) >> 1) + margin; }
  /** The other way: the pair of cells whose ground a place has, its own or that at the border. */
  TALUS_HD int pair_at(int place, int odd, int cells) const
  {
    return min_of(max_of(place - margin, 0), place_of(cells - 1, odd) - margin);
  }
};

TALUS_HD int coarse_margin(const Config& k) { return k.object_radius; }
/** Dilation goes one pair of cells farther than erosion: a pair that holds an edge and the ground
 * below it belongs to what it is the edge of. */
TALUS_HD int dilation_radius(const Config& k)
{
  return k.object_radius + (on(kDilatesFarther, k) ? 1 : 0);
}
/** Pairs that a thing covers at most, which is narrower than ground. */
TALUS_HD int widest_thing(const Config& k) { return 2 * dilation_radius(k); }

TALUS_HD int coarse_side(const Config& k) { return k.cells / 2 + 1 + 2 * coarse_margin(k); }

}  // namespace talus::kernels
