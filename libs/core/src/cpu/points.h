#pragma once
#include "kernels/1_points.h"
#include "kernels/2_follow.h"

namespace talus::kernels
{
// Stage 1 on cores: each thread has the points of its own part of the window, or of the directions.

/** Notes the ray of a point, how far it went, and how far its hit lies above the mapped ground. */
template <class Atomics>
struct NoteRayAndHit : NoteRay<SerialAtomics>
{
  NoteReach<SerialAtomics> reach;
  CountOffset<Atomics> offset;

  void operator()(int point_i) const
  {
    NoteRay<SerialAtomics>::operator()(point_i);
    reach(point_i);
    offset(point_i);
  }
};

/** Bins one point, if it is not buried, in a cell that no other thread uses. */
template <class Atomics>
struct BinPoint
{
  const Config* config;
  const FrameContext* frame;
  PointsOut points;
  const float* lowest_slope;  //!< for rays that are not buried, see SettleRays
  std::uint32_t* cell_count;  //!< by storage index, zero before
  std::uint32_t* rejected;  //!< by RejectCode

  /** Cells of the window in storage order; the range may wrap around. */
  Part part(int which, int of) const
  {
    const int n = config->cells, first = which * n / of, end = (which + 1) * n / of;
    const int begin = storage_index(*frame, n, 0, first) - frame->storage_x;
    return {begin, begin + (end - first) * n};
  }
  bool is_in(const Part& part, int point_i) const
  {
    const int n = config->cells, cell = points.cell[point_i];
    const int place = cell + select(cell < part.begin, n * n, 0);
    return (cell >= 0) & (place < part.end);
  }
  void operator()(int point_i) const
  {
    const int cell = points.cell[point_i];
    if (cell < 0) return;
    const int ray = points.ray[point_i];
    const bool buried = ray >= 0 && points.slope[point_i] < lowest_slope[ray];
    if (buried) Atomics::count(rejected + kBuried);
    points.rank[point_i] = buried ? kNoRank : cell_count[cell]++;
  }
};

}  // namespace talus::kernels
