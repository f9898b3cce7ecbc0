#pragma once
#include "cpu/clones.h"
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

/** What the lines may read of a cell, for which nothing is inferred yet. */
struct TakeSample
{
  kernels::ClassifyCell classify;
  kernels::LineGrid grid;
  kernels::Samples samples;
  std::uint16_t* marks;  //!< see InferenceGrid

  void operator()(int ix, int iy, int storage_i) const
  {
    const int line_i = grid.at(ix, iy);
    samples.height_m[line_i] = kernels::sample_of(classify, storage_i);
    marks[line_i] = 0;
  }
};

/** The inferred values of the cells, by place of the grid. */
struct InferenceGrid
{
  float *information, *weighted, *lowest_m;  //!< kernels::LineFusion
  std::uint16_t* marks;  //!< bits of FillMark; without kInferred no other value counts
  float* fall_m;  //!< see fall_in(); set where stage 7 needs it

  kernels::LineFusion lines(int i) const { return {information[i], weighted[i], lowest_m[i]}; }
  void set(int i, const kernels::LineFusion& lines) const
  {
    information[i] = lines.information;
    weighted[i] = lines.weighted;
    lowest_m[i] = lines.lowest_m;
  }
  void put(int i, const kernels::LineFusion& lines, std::int32_t marks_there) const
  {
    set(i, lines);
    marks[i] = static_cast<std::uint16_t>(marks_there);
  }
  TALUS_FETCHES void fetch_lines(int i) const
  {
    for (const float* values : {information, weighted, lowest_m}) __builtin_prefetch(values + i, 1);
  }
  TALUS_FETCHES void fetch(int i) const
  {
    fetch_lines(i);
    __builtin_prefetch(marks + i, 1);
  }
  void add(int i, const kernels::LineFusion& other) const
  {
    kernels::LineFusion sum = lines(i);
    sum.add(other);
    set(i, sum);
  }
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
