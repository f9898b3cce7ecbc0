#pragma once
#include "cpu/side_by_side.h"
#include "kernels/6_fill.h"

#include <algorithm>

// Stage 6's lines on the CPU. Sixteen lines, side by side, are swept from end to end and carry the
// samples that they met last; then back, so that each cell has those of both sides. So a cell costs
// the same however far its samples are, neighbours are read together, and all is vector code.

namespace talus::lines
{
constexpr int kLanes = 16;

/** The inferred values of the cells, by index of the grid. */
struct InferenceGrid
{
  const kernels::Map& m;

  kernels::LineFusion lines(int i) const
  {
    return {m.information[i], m.weighted[i], m.lowest_m[i]};
  }
  void set(int i, const kernels::LineFusion& lines) const
  {
    m.information[i] = lines.information;
    m.weighted[i] = lines.weighted;
    m.lowest_m[i] = lines.lowest_m;
  }
  TALUS_FETCHES void fetch_lines(int i) const
  {
    for (const float* values : {m.information, m.weighted, m.lowest_m})
      __builtin_prefetch(values + i, 1);
  }
  TALUS_FETCHES void fetch(int i) const
  {
    fetch_lines(i);
    __builtin_prefetch(m.fill_marks + i, 1);
  }
  void add(int i, const kernels::LineFusion& other) const
  {
    kernels::LineFusion sum = lines(i);
    sum.add(other);
    set(i, sum);
  }
};

/** Fills a cell from what the lines found. */
struct FillSwept
{
  const kernels::Map& m;

  void operator()(int x, int y, int i) const
  {
    const int at = m.lines.at(x, y);
    kernels::FillCell{m}(x, y, i, InferenceGrid{m}.lines(at), m.fill_marks[at]);
  }
};

/** The lines from the sensor, then columns, then rows, in parts that touch different cells. */
struct Walk
{
  const kernels::Map& m;

  int parts_of_rays() const { return 4 * parts(2 * kernels::line_rings(m.k)); }
  int parts_of_axis() const { return parts(m.k.cells); }
  int first_of(int part) const { return std::min(part * kLanes, m.k.cells); }

  void rays(int part) const;
  void rows(int part) const;
  void columns(int part) const;

 private:
  static int parts(int lines) { return (lines + kLanes - 1) / kLanes; }
};

}  // namespace talus::lines
