#pragma once
#include "kernels/4_classify.h"
#include "kernels/4_start.h"
#include "kernels/4_underfoot.h"
#include "kernels/5_cleanup.h"
#include "kernels/6_fill.h"

namespace talus::kernels
{
/** Stores whether a cell is a sample of fills, and returns it. */
TALUS_HD bool put_sample(const ClassifyCell& of, const Samples& samples, int storage_i, int line_i)
{
  samples.height_m[line_i] = sample_of(of, storage_i);
  return is_known(samples.height_m[line_i]);
}

/** Stage 4 on one cell. */
template <class Atomics>
TALUS_HD void settle(
    const StandOnCell<Atomics>& stand, const PresumeStart& presume, const ClassifyCell& classify,
    int ix, int iy, int storage_i)
{
  if (stand.applies(ix, iy, storage_i)) stand(ix, iy, storage_i);
  if (presume.applies_to_frame() && presume.applies(ix, iy, storage_i)) presume(ix, iy, storage_i);
  classify(ix, iy, storage_i);
}

/** The last steps before the search, for one cell: its class, the cleanup, and whether it is a
 * sample. */
template <class Atomics>
struct SettleCell
{
  StandOnCell<Atomics> stand;
  PresumeStart presume;
  ClassifyCell classify;
  LowerObject lower;
  CleanUpCell clean;
  LineGrid grid;
  Samples samples;

  /** First step. Returns whether inspect() must follow. */
  TALUS_HD bool begin(int ix, int iy) const
  {
    const int storage_i = index(ix, iy);
    settle(stand, presume, classify, ix, iy, storage_i);
    if (lower.applies(ix, iy, storage_i)) lower(ix, iy, storage_i);
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
    return put_sample(classify, samples, storage_i, grid.at(ix, iy));
  }

 private:
  TALUS_HD int index(int ix, int iy) const
  {
    return storage_index(*classify.frame, clean.cells, ix, iy);
  }
};

/** The same of a frame that starts a map, before it is known what the robot gets to. */
template <class Atomics>
struct SettleFirst
{
  StandOnCell<Atomics> stand;
  PresumeStart presume;
  ClassifyCell classify;
  LineGrid grid;
  Samples samples;

  TALUS_HD bool begin(int ix, int iy) const
  {
    settle(
        stand, presume, classify, ix, iy,
        storage_index(*classify.frame, classify.config->cells, ix, iy));
    return false;
  }
  template <class Group>
  TALUS_HD void inspect(int, int, const Group&) const
  {
  }
  TALUS_HD bool operator()(int ix, int iy) const
  {
    const int storage_i = storage_index(*classify.frame, classify.config->cells, ix, iy);
    return put_sample(classify, samples, storage_i, grid.at(ix, iy));
  }
};

}  // namespace talus::kernels
