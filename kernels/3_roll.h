#pragma once
#include "kernels/cell.h"

namespace talus::kernels
{
/** Stage 3 on cell (ix, iy) of the window, which follows the sensor by whole cells. Storage is a
 * torus, so what stays is not touched; a cell that was outside the last window starts empty. */
struct RollCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  float* top_hit_m;  //!< by storage index: highest point of this frame; -infinity: none yet

  /** Prepares the cell stored at storage_i; true if it starts empty. */
  TALUS_HD bool applies(int ix, int iy, int storage_i) const
  {
    top_hit_m[storage_i] = -kInfinity;
    return entered_window(*frame, config->cells, ix, iy);
  }
  TALUS_HD void operator()(int, int, int storage_i) const { store.store(storage_i, Cell{}); }

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int storage_i = storage_index(*frame, config->cells, ix, iy);
    if (applies(ix, iy, storage_i)) (*this)(ix, iy, storage_i);
  }
};

}  // namespace talus::kernels
