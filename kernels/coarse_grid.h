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

/** Cells of the map pooled two by two, by the parity of their place in the map, so that rolling
 * does not change the pairs. Nothing is known in a margin around the window. */
struct CoarseGrid
{
  int side;  //!< coarse cells along each side, with both margins
  static constexpr int kMargin = 1;  //!< in coarse cells
  int pad;  //!< places beside each row that hold infinity
  float* lowest_m;  //!< lowest measured ground; infinity: none
  float* known_m;  //!< lowest ground, measured or inferred; infinity: none
  float* column_m;  //!< highest upright top; -infinity: none
  float* presence;  //!< a Presence
  float* eroded_m;  //!< lowest ground of the neighbourhood; infinity: near an upright object, or
                    //!< nothing is known there
  float* cone_m;  //!< lowest ground of the neighbourhood, raised with distance
  float* apart_m;  //!< higher than the robot climbs from reached ground; infinity: none is near
  float* foot_m;  //!< lowest reached ground of the neighbourhood; infinity: none
  float* things_m;  //!< highest top above a step; infinity or -infinity: none
  float* beside_m;  //!< the highest of those beside
  float* limit_m;  //!< highest that ground can be there
  std::int32_t* reach;  //!< a Reach

  TALUS_HD int at(int px, int py) const { return py * (side + 2 * pad) + px + pad; }
  /** Where a cell of the window is found, along one axis. */
  TALUS_HD int place_of(int cell, int odd) const { return ((cell + odd) >> 1) + kMargin; }
  /** The pair of a cell of the window. */
  TALUS_HD int pair_of(int ix, int iy, const FrameContext& f) const
  {
    return at(place_of(ix, f.odd_x), place_of(iy, f.odd_y));
  }
  /** The first cell of the pair at a place, along one axis; perhaps outside. */
  TALUS_HD int first_cell(int place, int odd) const { return 2 * (place - kMargin) - odd; }
};

TALUS_HD int dilation_radius(const Config& k) { return k.object_radius + kDilatesFarther_pairs; }

/** Pools the cells of a pair, see PoolReach. */
template <class Pool>
TALUS_HD typename Pool::Item pool_pair(const Pool& f, int px, int py)
{
  const int n = f.config->cells;
  const int x0 = f.grid.first_cell(px, f.frame->odd_x), y0 = f.grid.first_cell(py, f.frame->odd_y);
  const auto cell = [&f, n](int x, int y)
  {
    const bool inside = (x >= 0) & (y >= 0) & (x < n) & (y < n);
    return inside ? f.item(storage_index(*f.frame, n, x, y)) : typename Pool::Item{};
  };
  return f.pool(
      f.pool(cell(x0, y0), cell(x0, y0 + 1)), f.pool(cell(x0 + 1, y0), cell(x0 + 1, y0 + 1)));
}

TALUS_HD int coarse_side(const Config& k) { return k.cells / 2 + 1 + 2 * CoarseGrid::kMargin; }

}  // namespace talus::kernels
