#pragma once
#include "cpu/side_by_side.h"
#include "cpu/swept_cells.h"

#include <algorithm>

// Stage 6's lines on the CPU. Sixteen lines, side by side, are swept from end to end, place by
// place, and carry the samples that they met last; then back, so that each cell has the samples of
// both sides. So a cell costs the same however far its samples are, neighbours are read together,
// and everything is vector code.

namespace talus::lines
{
constexpr int kLanes = 16;

/** The lines from the sensor, then columns, then rows, in parts that touch different cells. */
struct Walk
{
  const kernels::Config& k;
  kernels::LineGrid grid;
  kernels::Samples samples;
  kernels::InferenceGrid to;

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
