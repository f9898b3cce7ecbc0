#pragma once
#include "kernels/5_cleanup.h"
#include "kernels/6_fill.h"

namespace talus::kernels
{
/** Rules on one cell, before the search for samples. CleanUpCell is done in steps, since a group
 * inspects what may overhang. */
template <class... Rules>
struct SettleCell
{
  const Map& m;

  /** First step. Returns whether inspect() must follow. */
  TALUS_HD bool begin(int ix, int iy) const
  {
    const int i = m.at(ix, iy);
    bool inspects = false;
    (begin<Rules>(ix, iy, i, inspects), ...);
    return inspects;
  }
  template <class Group>
  TALUS_HD void inspect(int ix, int iy, const Group& group) const
  {
    if constexpr (kCleansUp) CleanUpCell{m}.inspect(ix, iy, m.at(ix, iy), group);
  }
  /** Last step. True for a sample. */
  TALUS_HD bool operator()(int ix, int iy) const
  {
    const int i = m.at(ix, iy);
    if constexpr (kCleansUp)
      if (CleanUpCell{m}.applies(ix, iy, i)) CleanUpCell{m}.finish(ix, iy, i);
    return TakeSample{m}(ix, iy, i);
  }

 private:
  static constexpr bool kCleansUp = (std::is_same_v<Rules, CleanUpCell> || ...);

  template <class Rule>
  TALUS_HD void begin(int ix, int iy, int i, bool& inspects) const
  {
    if constexpr (std::is_same_v<Rule, CleanUpCell>)
      inspects = CleanUpCell{m}.needs_inspection(ix, iy, i);
    else
      apply<Rule>(m, ix, iy, i);
  }
};

}  // namespace talus::kernels
