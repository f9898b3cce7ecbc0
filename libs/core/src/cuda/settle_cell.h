#pragma once
#include "kernels/5_classify.h"
#include "kernels/6_cleanup.h"
#include "kernels/7_fill.h"

namespace talus::kernels
{
/** The last steps before the search, on one cell: its role, the cleanup, and whether it is a
 * sample. */
struct SettleCell
{
  ChooseRole choose;
  CleanUpCell clean;
  LineGrid grid;
  Samples samples;

  enum Look
  {
    kNoLook,
    kLookForFace,  //!< and then, where that is still wanted, the other
    kLookThrough
  };
  /** First. Which look has to come next. */
  TALUS_HD int begin(int ix, int iy) const
  {
    const int i = index(ix, iy);
    choose.decide(ix, iy, i);
    if (choose.wants_look(ix, iy, i)) return kLookForFace;
    return clean.wants_look(ix, iy, i) ? kLookThrough : kNoLook;
  }
  template <class Team>
  TALUS_HD void look(int ix, int iy, int which, const Team& team) const
  {
    const int i = index(ix, iy);
    if (which == kLookForFace)
    {
      choose.look(ix, iy, i, team);
      team.sync();
      if (!clean.wants_look(ix, iy, i)) return;
    }
    clean.look(ix, iy, i, team);
  }
  /** Last. True for a sample. */
  TALUS_HD bool operator()(int ix, int iy) const
  {
    const int i = index(ix, iy);
    if (clean.concerns(ix, iy, i)) clean.finish(ix, iy, i);
    const bool sample = is_sample(clean.store, clean.role, i);
    const float ground_m = clean.store.ground_m[i];
    const int o = grid.at(ix, iy);
    samples.height_m[o] = sample ? ground_m : kNan;
    if (sample)
      samples.variance_or_bound[o] = sample_variance(
          ground_m, clean.store.ground_var_m2[i], clean.passing.lowest_m[iy * clean.cells + ix]);
    return sample;
  }

 private:
  TALUS_HD int index(int ix, int iy) const
  {
    return storage_index(*choose.frame, clean.cells, ix, iy);
  }
};

}  // namespace talus::kernels
