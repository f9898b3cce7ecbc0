#pragma once
#include "kernels/cell.h"
#include "kernels/coarse_grid.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"
#include "kernels/rule_switches.h"

namespace talus::kernels
{

/** Sets the class of a cell from its state and from the highest that ground can be there. */
struct ClassifyCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  CoarseGrid grid;
  std::uint8_t* surface_class;  //!< by storage index

  TALUS_HD void operator()(int x, int y, int storage_i) const
  {
    surface_class[storage_i] = static_cast<std::uint8_t>(class_of(x, y, storage_i));
  }
  TALUS_HD int class_of(int x, int y, int storage_i) const
  {
    const int state = store.state[storage_i];
    const int coarse_i = grid.at(grid.place_of(x, frame->odd_x), grid.place_of(y, frame->odd_y));
    const bool ground =
        (store.ground_m[storage_i] <= grid.limit_m[coarse_i]) | !on(kNarrowAndSteep, *config);
    const int of_measured = select(ground, kKeep, kObject);
    const int of_others = select(state == kPresumed, kKeep, kInfer);
    return select(state == kMeasured, of_measured, of_others);
  }
};

/** Makes an object ground again where level, bare ground leads straight from it to wide ground. A
 * bridge, a dam or a jetty is narrow and steep, but no object. */
struct KeepBridge
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  CoarseGrid grid;
  std::uint8_t* surface_class;  //!< by storage index

  TALUS_HD bool applies(int, int, int storage_i) const
  {
    return (surface_class[storage_i] == kObject) & on(kBridges, *config);
  }
  TALUS_HD void operator()(int x, int y, int storage_i) const
  {
    if (leads_on(x, y, storage_i)) surface_class[storage_i] = kKeep;
  }
  TALUS_HD bool leads_on(int x, int y, int storage_i) const
  {
    const int px = grid.place_of(x, frame->odd_x), py = grid.place_of(y, frame->odd_y);
    const float ground_m = store.ground_m[storage_i];
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++)
        if ((dx != 0 || dy != 0) && reaches_wide_ground(px, py, dx, dy, ground_m)) return true;
    return false;
  }

 private:
  TALUS_HD bool reaches_wide_ground(int px, int py, int dx, int dy, float ground_m) const
  {
    const float tolerance_m = kAboveCone_steps * config->step_threshold_m;
    for (int r = 1; r <= widest_thing(*config); r++)
    {
      const int qx = px + r * dx, qy = py + r * dy;
      if (qx < 0 || qy < 0 || qx >= grid.side || qy >= grid.side) return false;
      const int coarse_i = grid.at(qx, qy);
      const float lowest_m = grid.lowest_m[coarse_i], eroded_m = grid.eroded_m[coarse_i];
      const bool level = abs_of(lowest_m - ground_m) <= tolerance_m;  // false if unknown
      if (!level || grid.column_m[coarse_i] > -kInfinity) return false;
      if (eroded_m >= lowest_m - tolerance_m && eroded_m < kInfinity) return true;
    }
    return false;
  }
};

}  // namespace talus::kernels
