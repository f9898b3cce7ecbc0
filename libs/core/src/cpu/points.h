#pragma once
#include "kernels/1_buried_rays.h"
#include "kernels/1_points.h"
#include "kernels/2_follow.h"

namespace talus::kernels
{
// Stage 1 on cores: each thread has the points of its own part of the window, or of the directions.

/** Notes the ray of a point, how far it went, and how far its hit lies above the mapped ground. */
template <class Atomics>
struct NoteRayAndHit : NoteRay<SerialAtomics>
{
  void operator()(int point_i) const
  {
    NoteRay<SerialAtomics>::operator()(point_i);
    NoteReach<SerialAtomics>{m}(point_i);
    CountOffset<Atomics>{m}(point_i);
  }
};

/** Bins one point, if it is not buried, in a cell that no other thread uses. */
template <class Atomics>
struct BinPoint
{
  const Map& m;

  /** Cells of the window in storage order; the range may wrap around. */
  Part part(int which, int of) const
  {
    const int n = m.k.cells, first = which * n / of, end = (which + 1) * n / of;
    const int begin = m.at(0, first) - m.frame->storage_x;
    return {begin, begin + (end - first) * n};
  }
  bool is_in(const Part& part, int point_i) const
  {
    const int n = m.k.cells, cell = m.point_cell[point_i];
    const int index = cell + select(cell < part.begin, n * n, 0);
    return (cell >= 0) & (index < part.end);
  }
  void operator()(int point_i) const
  {
    const int cell = m.point_cell[point_i];
    if (cell < 0) return;
    const bool buried = is_buried(m, point_i);
    if (buried) Atomics::count(m.counts->rejected + kBuried);
    m.point_rank[point_i] = buried ? kNoRank : m.cell_count[cell]++;
  }
};

}  // namespace talus::kernels
