#pragma once
#include "kernels/cell.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/math.h"

namespace talus::kernels
{
/** Before all rules of a frame: no cell was hit yet. */
struct ForgetHits
{
  float* top_hit_m;  //!< by storage index: highest point of this frame; -infinity: none yet

  TALUS_HD void operator()(int, int, int storage_i) const { top_hit_m[storage_i] = -kInfinity; }
};

/** Stage 2 on cell (ix, iy) of the window, which follows the robot by whole cells. Storage is a
 * torus, so what stays is not touched; a cell that was outside the last window starts empty, and
 * all do on another floor. */
struct RollCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const Datum* datum;

  TALUS_HD bool applies(int ix, int iy, int) const
  {
    return entered_window(*frame, config->cells, ix, iy) | (datum->starts_anew != 0);
  }
  TALUS_HD void operator()(int, int, int storage_i) const { store.store(storage_i, Cell{}); }
};

}  // namespace talus::kernels
