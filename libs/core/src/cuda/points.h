#pragma once
#include "kernels/1_points.h"
#include "kernels/2_follow.h"
#include "kernels/2_roll.h"
#include "kernels/3_update.h"
#include "kernels/9_channels.h"

namespace talus::kernels
{
// Stages 1 to 3 on a device, a thread for each point. Points are counted in their cells before the
// buried ones are known, and each cell reserves a range of the sorted points.

/** Stage 1 on one point; counts it in its cell, even if it is buried, and in the histogram of
 * offsets. The point is there before the frame's context is. */
template <class Atomics>
struct AcceptAndCountPoint
{
  AcceptPoint<Atomics> accept;
  CountOffset<Atomics> count_offset;
  std::uint32_t* cell_count;  //!< by storage index, zero before

  TALUS_HD Point early(int point_i) const { return accept.in.at(point_i); }
  TALUS_HD void operator()(int point_i, const Point& sensed) const
  {
    if (point_i >= accept.frame->n_points) return;
    accept.locate(point_i, sensed);
    accept.note(point_i);
    const int cell = accept.out.cell[point_i];
    if (cell < 0) return;
    const std::uint32_t rank = Atomics::add(cell_count + cell, 1);
    if (!is_cleared(cell)) count_offset(point_i);
    accept.out.rank[point_i] = rank;
  }

 private:
  /** Whether stage 2 clears a cell, perhaps at this moment. */
  TALUS_HD bool is_cleared(int storage_i) const
  {
    const FrameContext& f = *accept.frame;
    const int n = accept.config->cells, row = floor_div(storage_i, n);
    const int x = storage_i - row * n - f.storage_x, y = row - f.storage_y;
    const int ix = x + select(x < 0, n, 0), iy = y + select(y < 0, n, 0);
    return !staying(f, n, iy, count_offset.datum->starts_anew != 0).has(ix);
  }
};

/** Stage 2 on one cell; clears the reach of the last frame's rays, see NoteReach, and keeps the
 * datum of that frame. */
struct RollCellAndReach
{
  ForgetHits forget;
  RollCell roll;
  Datum* datum_before;
  std::int32_t* reach;
  int size;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int cells = roll.config->cells, i = storage_index(*roll.frame, cells, ix, iy);
    forget(ix, iy, i);
    if (roll.applies(ix, iy, i)) roll(ix, iy, i);
    for (int at = iy * cells + ix; at < size; at += cells * cells) reach[at] = 0;
    if (ix == 0 && iy == 0) *datum_before = *roll.datum;
  }
};

/** The first point of a cell reserves its range. */
template <class Atomics>
struct ReserveStretch
{
  const FrameContext* frame;
  PointsOut points;
  Sorting sorting;

  TALUS_HD void operator()(int point_i) const
  {
    if (point_i >= frame->n_points || points.cell[point_i] < 0 || points.rank[point_i] != 0) return;
    const int cell = points.cell[point_i];
    const std::uint64_t count = sorting.cell_count[cell];
    const bool crowded = count > sorting.crowd;
    const std::uint64_t at = Atomics::reserve(sorting.cursor, crowded ? count | 1ull << 32 : count);
    sorting.cell_begin[cell] = static_cast<std::uint32_t>(at);
    if (crowded) sorting.crowded[at >> 32] = cell;
  }
};

/** Sorts one point unless it is buried, and notes how far its ray went. */
template <class Atomics>
struct SortUnburiedPoint
{
  SortPoint sort;
  NoteReach<Atomics> reach;
  const float* lowest_slope;  //!< for rays that are not buried
  std::uint32_t* kept_count;  //!< by storage index, zero before
  std::uint32_t* rejected;  //!< by RejectCode

  TALUS_HD void operator()(int point_i) const
  {
    const PointsOut& points = sort.points;
    if (point_i >= sort.frame->n_points) return;
    reach(point_i);
    if (points.cell[point_i] < 0) return;
    const int ray = points.ray[point_i];
    if (ray >= 0 && points.slope[point_i] < lowest_slope[ray])
      Atomics::count(rejected + kBuried);
    else
      sort.put(
          point_i, Atomics::add(kept_count + points.cell[point_i], 1), sort.overhangs(point_i));
  }
};

/** Finds the surface of a point and adds its channels to it. */
template <class Atomics>
struct PlaceAndAddPoint
{
  PlacePoint place;
  Channels channels;
  std::uint8_t* begins;  //!< by point: a bit for each channel of which it is the first there

  TALUS_HD void operator()(int point_i) const
  {
    int first = 0;
    if (point_i < place.frame->n_points)
    {
      place(point_i);
      const std::int32_t at = place.surface[point_i];
      for (int c = 0; c < channels.size && at >= 0; c++)
        if (channels.each[c].template add<Atomics>(at, channels.each[c].of_points[point_i]))
          first |= 1 << c;
    }
    begins[point_i] = static_cast<std::uint8_t>(first);
  }
};

/** Settles what the point began. */
struct SettlePoint
{
  SettleChannel settle;  //!< of any channel
  Channels channels;
  const std::int32_t* surface;
  const std::uint8_t* begins;

  TALUS_HD void operator()(int point_i) const
  {
    const int begun = begins[point_i];
    for (int c = 0; c < channels.size && begun >> c != 0; c++)
      if (begun >> c & 1)
        SettleChannel{settle.config, settle.store, channels.each[c]}(surface[point_i]);
  }
};

}  // namespace talus::kernels
