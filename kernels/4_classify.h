#pragma once
#include "kernels/map.h"

namespace talus::kernels
{
/** The class of a cell, by its state and the highest that ground can be there; keeps its reach. */
struct ClassifyCell
{
  const Map& m;

  TALUS_HD void operator()(int x, int y, int i) const
  {
    // Reads come before stores, and no bit is tested alone, or the loop would not be vectorised.
    const int pair = m.pair_of(x, y), before = m.cell.flags[i];
    const int state = m.cell.state[i];
    const float ground_m = m.cell.ground_m[i];
    const bool reached = m.pair_reach[pair] == kPairReached,
               apart = ground_m > m.pair_apart_m[pair];
    const int marks = select(reached, 0, kObjectTop | select(apart, kWasPassable, 0));
    const int top = select((before & marks) != 0, kObjectTop, 0);
    const int result = class_of(state, (ground_m > m.pair_limit_m[pair]) | (apart & (top != 0)));
    m.cell.flags[i] = static_cast<std::uint8_t>(
        (before & ~(kWasReached | kObjectTop)) | select(reached, kWasReached, 0) | top);
    m.surface_class[i] = static_cast<std::uint8_t>(result);
  }
  TALUS_HD int class_of(int x, int y, int i) const
  {
    const int pair = m.pair_of(x, y);
    const float ground_m = m.cell.ground_m[i];
    const bool top = m.cell.is(kObjectTop, i) & (ground_m > m.pair_apart_m[pair]);
    return class_of(m.cell.state[i], (ground_m > m.pair_limit_m[pair]) | top);
  }

 private:
  TALUS_HD int class_of(int state, bool object) const
  {
    const int of_measured = select(object & on(kReach, m.k), kObject, kKeep);
    const int of_others = select(state == kPresumed, kKeep, kInfer);
    return select(state == kMeasured, of_measured, of_others);
  }
};

/** The ground below an object is as high as what is reached around it, until stage 6 infers it from
 * lines. Not all of its lines have samples. */
struct LowerObject
{
  const Map& m;

  TALUS_HD bool applies(int, int, int i) const { return m.surface_class[i] == kObject; }
  TALUS_HD void operator()(int x, int y, int i) const
  {
    const float foot_m = m.pair_foot_m[m.pair_of(x, y)];
    const float before_m = m.cell.ground_m[i];
    if (!(foot_m < before_m)) return;  // also if it is not known
    if (before_m - foot_m > m.k.clearance_m) m.cell.flags[i] |= kHitHighUp;
    m.cell.ground_m[i] = foot_m;
    m.cell.ground_var_m2[i] = kFoot_var_m2;
    m.cell.state[i] = kFilledOneSided;
  }
};

/** Forgets a fill: it rested on what is no ground. */
struct ForgetFill
{
  const Map& m;

  TALUS_HD void operator()(int, int, int i) const
  {
    const int state = m.cell.state[i], flags = m.cell.flags[i];
    const bool fill = (state == kFilledTwoSided) | (state == kFilledOneSided);
    m.cell.ground_m[i] = select(fill, kNan, m.cell.ground_m[i]);
    m.cell.ground_var_m2[i] = select(fill, kNan, m.cell.ground_var_m2[i]);
    m.cell.state[i] = static_cast<std::uint8_t>(select(fill, static_cast<int>(kUnknown), state));
    m.cell.flags[i] =
        static_cast<std::uint8_t>(flags & select(fill, ~(kPassedLow | kPossibleDropOff), ~0));
  }
};

}  // namespace talus::kernels
