#pragma once
#include "cpu/side_by_side.h"
#include "kernels/6_fill.h"

#include <algorithm>

// Stage 6's lines on the CPU. Sixteen lines, side by side, are swept from end to end, place by
// place, and carry the samples that they met last; then back, so that each cell has the samples of
// both sides. So a cell costs the same however far its samples are, neighbours are read together,
// and everything is vector code.

namespace talus::lines
{
constexpr int kLanes = 16;

/** What the lines may read of a cell. */
struct TakeSample
{
  const kernels::Config& config;
  kernels::CellStore store;
  const std::uint8_t* surface_class;
  kernels::PassingRays passing;
  kernels::LineGrid grid;
  kernels::Samples samples;

  void operator()(int ix, int iy, int storage_i) const
  {
    const int line_i = grid.at(ix, iy), window_i = iy * config.cells + ix;
    const bool sample = kernels::is_sample(store, surface_class, storage_i);
    const float ground_m = store.ground_m[storage_i];
    const float variance_m2 = store.ground_var_m2[storage_i];
    const float free_m = kernels::free_above_m(passing, window_i);
    samples.height_m[line_i] = kernels::select(sample, ground_m, kernels::kNan);
    samples.variance_m2[line_i] = variance_m2;
    samples.free_above_m[line_i] = free_m;
  }
};

/** The inferred values of the cells, by place of the grid. */
struct InferenceGrid
{
  kernels::Inference* cells;
  std::uint8_t* marks;  //!< bits of FillMark
  float* fall_m;  //!< see fall_in(); set where stage 7 needs it
};

/** The lines from the sensor, then columns, then rows, in parts that touch different cells. */
struct Walk
{
  const kernels::Config& k;
  kernels::LineGrid grid;
  kernels::Samples samples;
  InferenceGrid to;

  int parts_of_rays() const { return 4 * parts(2 * kernels::line_rings(k)); }
  int parts_of_axis() const { return parts(k.cells); }
  int first_of(int part) const { return std::min(part * kLanes, k.cells); }

  void rays(int part) const;
  void rows(int part) const;
  void columns(int part) const;

 private:
  static int parts(int lines) { return (lines + kLanes - 1) / kLanes; }
};

}  // namespace talus::lines
