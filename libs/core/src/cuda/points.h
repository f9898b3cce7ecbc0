#pragma once
#include "kernels/1_buried_rays.h"
#include "kernels/1_points.h"
#include "kernels/2_follow.h"
#include "kernels/3_update.h"

namespace talus::kernels
{
// Stages 1 to 3 on a device, a thread for each point. Points are counted in their cells before the
// buried ones are known, and each cell reserves a range of the sorted points.

/** A rule on none of the elements of a launch. */
struct Nothing
{
  const Map& m;

  TALUS_HD void operator()(int) const {}
};

/** Stage 1 on one point; counts it in its cell, even if it is buried, and in the histogram of
 * offsets. The point is there before the frame's context is. */
template <class Atomics>
struct AcceptAndCountPoint
{
  const Map& m;

  TALUS_HD Point early(int point_i) const { return m.in.at(point_i); }
  TALUS_HD void operator()(int point_i, const Point& sensed) const
  {
    if (point_i >= m.frame->n_points) return;
    const AcceptPoint<Atomics> accept{m};
    accept.locate(point_i, sensed);
    accept.note(point_i);
    const int cell = m.point_cell[point_i];
    if (cell < 0) return;
    const std::uint32_t rank = Atomics::add(m.cell_count + cell, 1);
    if (!is_cleared(cell)) CountOffset<Atomics>{m}(point_i);
    m.point_rank[point_i] = rank;
  }

 private:
  /** Whether stage 2 clears a cell, perhaps at this moment. */
  TALUS_HD bool is_cleared(int storage_i) const
  {
    const FrameContext& f = *m.frame;
    const int n = m.k.cells, row = floor_div(storage_i, n);
    const int x = storage_i - row * n - f.storage_x, y = row - f.storage_y;
    const int ix = x + select(x < 0, n, 0), iy = y + select(y < 0, n, 0);
    return !staying(f, n, iy, m.datum->starts_anew != 0).has(ix);
  }
};

/** Clears the reach of the last frame's rays, see NoteReach, and keeps the datum of that frame. */
struct ForgetReach
{
  const Map& m;

  TALUS_HD void operator()(int ix, int iy, int) const
  {
    const int cells = m.k.cells * m.k.cells, size = bin_count(m.k) * kSlopeBins;
    for (int at = m.window_at(ix, iy); at < size; at += cells) m.reach[at] = 0;
    if (ix == 0 && iy == 0) *m.datum_before = *m.datum;
  }
};

template <class Atomics>
struct ReserveRange
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    if (point_i >= m.frame->n_points || m.point_cell[point_i] < 0 || m.point_rank[point_i] != 0)
      return;
    const int cell = m.point_cell[point_i];
    const std::uint64_t count = m.cell_count[cell];
    const bool crowded = count > kCrowd;
    const std::uint64_t at = Atomics::reserve(m.cursor, crowded ? count + kOneCrowded : count);
    m.cell_begin[cell] = ends_of(at).sorted;
    if (crowded) m.crowded[ends_of(at).crowded] = cell;
  }
};

/** Sorts one point unless it is buried, and notes how far its ray went. */
template <class Atomics>
struct SortUnburiedPoint
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    if (point_i >= m.frame->n_points) return;
    NoteReach<Atomics>{m}(point_i);
    if (m.point_cell[point_i] < 0) return;
    const SortPoint sort{m};
    if (is_buried(m, point_i))
      Atomics::count(m.counts->rejected + kBuried);
    else
      sort.put(
          point_i, Atomics::add(m.kept_count + m.point_cell[point_i], 1), sort.overhangs(point_i));
  }
};

/** Hands over the counters and resets the memory for the next frame; one of workers() threads. */
struct ResetFrame
{
  const Map& m;

  static TALUS_HD int workers(const Config& k) { return k.cells * k.cells / 8 + 1; }
  TALUS_HD void operator()(int worker) const
  {
    const int step = workers(m.k), cells = m.k.cells * m.k.cells;
    const int n_rays = bin_count(m.k) * most_rings(m.k.cells);
    for (int i = worker; i < n_rays; i += step) m.rays[i] = kNoRay;
    for (int i = worker; i < cells; i += step) m.cell_count[i] = m.kept_count[i] = 0;
    if (worker != 0) return;
    *m.reported = *m.counts;
    *m.counts = {};
    *m.cursor = 0;
  }
};

}  // namespace talus::kernels
