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
  /** Goes in eight directions at once, so that their loads do not wait for each other. */
  TALUS_HD bool leads_on(int x, int y, int storage_i) const
  {
    const int px = grid.place_of(x, frame->odd_x), py = grid.place_of(y, frame->odd_y);
    const float ground_m = store.ground_m[storage_i];
    int ways = kAllWays;
    bool arrived = false;
    for (int r = 1; r <= widest_thing(*config) && ways != 0 && !arrived; r++)
      arrived = step(px, py, r, ground_m, ways);
    return arrived;
  }

 private:
  static constexpr int kWays = 9;  //!< the middle one leads nowhere
  static constexpr int kAllWays = 0x1ef, kLeft = 0x049, kRight = 0x124, kLow = 0x007, kHigh = 0x1c0;

  /** Takes the step `r` of the ways that go on so far. Returns whether one reaches wide ground. */
  TALUS_HD bool step(int px, int py, int r, float ground_m, int& ways) const
  {
    const float tolerance_m = kAboveCone_steps * config->step_threshold_m;
    ways &=
        ~(select(px < r, kLeft, 0) | select(px + r >= grid.side, kRight, 0) |
          select(py < r, kLow, 0) | select(py + r >= grid.side, kHigh, 0));
    const int here = grid.at(px, py), row = grid.at(0, 1) - grid.at(0, 0);
    float lowest_m[kWays], eroded_m[kWays], column_m[kWays];
    for (int w = 0; w < kWays; w++)
    {
      const bool goes_on = (ways >> w & 1) != 0;
      const int coarse_i = here + r * (w % 3 - 1 + (w / 3 - 1) * row);
      lowest_m[w] = goes_on ? grid.lowest_m[coarse_i] : kInfinity;
      eroded_m[w] = goes_on ? grid.eroded_m[coarse_i] : kInfinity;
      column_m[w] = goes_on ? grid.column_m[coarse_i] : kInfinity;
    }
    bool arrives = false;
    for (int w = 0; w < kWays; w++)
    {
      const bool level = abs_of(lowest_m[w] - ground_m) <= tolerance_m;  // false if unknown
      const bool goes_on = level & !(column_m[w] > -kInfinity);
      ways &= ~(select(goes_on, 0, 1) << w);
      const bool wide = (eroded_m[w] >= lowest_m[w] - tolerance_m) & (eroded_m[w] < kInfinity);
      arrives |= goes_on & wide;
    }
    return arrives;
  }
};

}  // namespace talus::kernels
