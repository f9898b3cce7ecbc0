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

/** Sets the class of a cell from its state and from the highest that ground can be there, and keeps
 * its reach. */
struct ClassifyCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  CoarseGrid grid;
  std::uint8_t* surface_class;  //!< by storage index

  TALUS_HD void operator()(int x, int y, int storage_i) const
  {
    // Reads come before stores, and no bit is tested alone, or the loop would not be vectorised.
    const int pair = grid.pair_of(x, y, *frame), before = store.flags[storage_i];
    const int state = store.state[storage_i];
    const float ground_m = store.ground_m[storage_i];
    const bool reached = grid.reach[pair] == kPairReached, apart = ground_m > grid.apart_m[pair];
    const int asked = select(reached, 0, kObjectTop | select(apart, kWasPassable, 0));
    const int top = select((before & asked) != 0, kObjectTop, 0);
    const int result = class_of(state, (ground_m > grid.limit_m[pair]) | (apart & (top != 0)));
    store.flags[storage_i] = static_cast<std::uint8_t>(
        (before & ~(kWasReached | kObjectTop)) | select(reached, kWasReached, 0) | top);
    surface_class[storage_i] = static_cast<std::uint8_t>(result);
  }
  TALUS_HD int class_of(int x, int y, int storage_i) const
  {
    const int pair = grid.pair_of(x, y, *frame);
    const float ground_m = store.ground_m[storage_i];
    const bool top = store.is(kObjectTop, storage_i) & (ground_m > grid.apart_m[pair]);
    return class_of(store.state[storage_i], (ground_m > grid.limit_m[pair]) | top);
  }

 private:
  TALUS_HD int class_of(int state, bool object) const
  {
    const int of_measured = select(object & on(kReach, *config), kObject, kKeep);
    const int of_others = select(state == kPresumed, kKeep, kInfer);
    return select(state == kMeasured, of_measured, of_others);
  }
};

/** The ground below an object is as high as what is reached around it, until stage 6 infers it from
 * lines. Not all of its lines have samples. */
struct LowerObject
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  CoarseGrid grid;
  const std::uint8_t* surface_class;  //!< by storage index

  TALUS_HD bool applies(int, int, int storage_i) const
  {
    return surface_class[storage_i] == kObject;
  }
  TALUS_HD void operator()(int x, int y, int storage_i) const
  {
    const float foot_m = grid.foot_m[grid.pair_of(x, y, *frame)];
    const float before_m = store.ground_m[storage_i];
    if (!(foot_m < before_m)) return;  // also if it is not known
    if (before_m - foot_m > config->clearance_m) store.flags[storage_i] |= kHitHighUp;
    store.ground_m[storage_i] = foot_m;
    store.ground_var_m2[storage_i] = kFoot_var_m2;
    store.state[storage_i] = kFilledOneSided;
  }
};

/** Forgets a fill: it rested on what is no ground. */
struct ForgetFill
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;

  TALUS_HD void operator()(int, int, int storage_i) const
  {
    const int state = store.state[storage_i], flags = store.flags[storage_i];
    const bool fill = (state == kFilledTwoSided) | (state == kFilledOneSided);
    store.ground_m[storage_i] = select(fill, kNan, store.ground_m[storage_i]);
    store.ground_var_m2[storage_i] = select(fill, kNan, store.ground_var_m2[storage_i]);
    store.state[storage_i] =
        static_cast<std::uint8_t>(select(fill, static_cast<int>(kUnknown), state));
    store.flags[storage_i] =
        static_cast<std::uint8_t>(flags & select(fill, ~(kPassedLow | kMayDrop), ~0));
  }
  TALUS_HD void operator()(int ix, int iy) const
  {
    (*this)(ix, iy, storage_index(*frame, config->cells, ix, iy));
  }
};

}  // namespace talus::kernels
