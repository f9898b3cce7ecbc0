#pragma once
#include "kernels/map.h"

namespace talus::kernels
{
/** Clears the highest hit of a cell, before all rules of a frame. */
struct ForgetHits
{
  const Map& m;

  TALUS_HD void operator()(int, int, int i) const { m.top_hit_m[i] = -kInfinity; }
};

/** Stage 2 on cell (ix, iy) of the window, which follows the robot by whole cells. Storage is a
 * torus, so that cells that stay do not move. A cell that enters the window starts empty, and on
 * another floor all cells do. */
struct RollCell
{
  const Map& m;

  TALUS_HD Stretch stays(int iy) const
  {
    return staying(*m.frame, m.k.cells, iy, m.datum->starts_anew != 0);
  }
  TALUS_HD bool applies(int ix, int iy, int) const { return !stays(iy).has(ix); }
  TALUS_HD void operator()(int, int, int i) const { m.cell.store(i, Cell{}); }
};

}  // namespace talus::kernels
