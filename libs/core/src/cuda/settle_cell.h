#pragma once
#include "kernels/4_classify.h"
#include "kernels/4_start.h"
#include "kernels/4_underfoot.h"
#include "kernels/5_cleanup.h"
#include "kernels/6_fill.h"

namespace talus::kernels
{
/** The last steps before the search, for one cell: its class, the cleanup, and whether it is a
 * sample. */
template <class Atomics>
struct SettleCell
{
  StandOnCell<Atomics> stand;
  PresumeStart presume;
  ClassifyCell classify;
  KeepBridge keep_bridge;
  CleanUpCell clean;
  LineGrid grid;
  Samples samples;

  /** First step. Returns whether inspect() must follow. */
  TALUS_HD bool begin(int ix, int iy) const
  {
    const int storage_i = index(ix, iy);
    if (stand.applies(ix, iy, storage_i)) stand(ix, iy, storage_i);
    if (presume.applies_to_frame() && presume.applies(ix, iy, storage_i))
      presume(ix, iy, storage_i);
    classify(ix, iy, storage_i);
    if (keep_bridge.applies(ix, iy, storage_i)) keep_bridge(ix, iy, storage_i);
    return clean.needs_inspection(ix, iy, storage_i);
  }
  template <class Group>
  TALUS_HD void inspect(int ix, int iy, const Group& group) const
  {
    clean.inspect(ix, iy, index(ix, iy), group);
  }
  /** Last step. True for a sample. */
  TALUS_HD bool operator()(int ix, int iy) const
  {
    const int storage_i = index(ix, iy);
    if (clean.applies(ix, iy, storage_i)) clean.finish(ix, iy, storage_i);
    const bool sample = is_sample(clean.store, clean.surface_class, storage_i);
    const float ground_m = clean.store.ground_m[storage_i];
    const int line_i = grid.at(ix, iy);
    samples.height_m[line_i] = sample ? ground_m : kNan;
    return sample;
  }

 private:
  TALUS_HD int index(int ix, int iy) const
  {
    return storage_index(*classify.frame, clean.cells, ix, iy);
  }
};

}  // namespace talus::kernels
