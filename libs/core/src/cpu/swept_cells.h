#pragma once
#include "kernels/6_fill.h"

namespace talus::kernels
{
// Stage 6 before and after the lines are swept, see cpu/lines.h.

struct TakeSample
{
  const Config* config;
  CellStore store;
  const std::uint8_t* surface_class;
  PassingRays passing;
  LineGrid grid;
  Samples samples;

  TALUS_HD void operator()(int ix, int iy, int storage_i) const
  {
    const int line_i = grid.at(ix, iy), window_i = iy * config->cells + ix;
    const bool sample = is_sample(store, surface_class, storage_i);
    const float ground_m = store.ground_m[storage_i];
    const float variance_m2 = store.ground_var_m2[storage_i];
    const float free_m = free_above_m(passing, window_i);
    samples.height_m[line_i] = select(sample, ground_m, kNan);
    samples.variance_m2[line_i] = variance_m2;
    samples.free_above_m[line_i] = free_m;
  }
};

/** The inferred values of the cells, by place of the grid. */
struct InferenceGrid
{
  Inference* cells;
  std::uint8_t* marks;  //!< bits of FillMark
  float* fall_m;  //!< see fall_in(); set where stage 7 needs it
};

/** Fills cell (ix, iy) from the swept lines. */
struct FillWalkedCell
{
  FillCell fill;
  LineGrid grid;
  InferenceGrid inferred;

  TALUS_HD void operator()(int ix, int iy, int storage_i) const
  {
    const int line_i = grid.at(ix, iy);
    fill(ix, iy, storage_i, inferred.cells[line_i], inferred.marks[line_i]);
  }
};

}  // namespace talus::kernels
