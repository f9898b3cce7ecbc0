#pragma once
#include "kernels/cell.h"

namespace talus::kernels
{
/** Stage 3 on cell (ix, iy) of the window, which follows the robot by whole cells. Storage is a
 * torus, so what stays is not touched; a cell that was outside the last window starts empty, and
 * all do on another floor. */
struct RollCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const Datum* datum;
  float* top_hit_m;  //!< by storage index: highest point of this frame; -infinity: none yet

  /** Prepares the cell stored at storage_i; true if it starts empty. */
  TALUS_HD bool applies(int ix, int iy, int storage_i) const
  {
    top_hit_m[storage_i] = -kInfinity;
    return entered_window(*frame, config->cells, ix, iy) | (datum->starts_anew != 0);
  }
  TALUS_HD void operator()(int, int, int storage_i) const { store.store(storage_i, Cell{}); }

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int storage_i = storage_index(*frame, config->cells, ix, iy);
    if (applies(ix, iy, storage_i)) (*this)(ix, iy, storage_i);
  }
};

}  // namespace talus::kernels
