#pragma once
#include "kernels/1_points.h"
#include "kernels/atomics.h"
#include "kernels/map.h"

namespace talus::kernels
{
// Poses drift and are corrected, and robots change floors. So the map keeps its heights above a
// datum. Each frame measures how far its ground hits lie above the mapped ground. Where most agree,
// the datum and all cells follow the poses. On another floor the next frame starts the map anew.

/** Histogram of the heights of ground hits above the mapped ground. */
struct OffsetHistogram
{
  static constexpr int kBins = 64;
  std::uint32_t count[kBins];
  std::uint32_t sum[kBins];  //!< sums of heights in 1 / kHeightUnits m; they wrap below zero
  std::uint32_t far;  //!< hits beyond the bins
};

/** Adds a point to the histogram if it is in the sample and the sensor looks down there on
 * measured, bare ground that was passable, which a wall is not, but not where it drove through
 * grass: blades stand up again. Buried points lie far below, so that they do not count. */
template <class Atomics>
struct CountOffset
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    const int ray = m.point_ray[point_i], storage_i = m.point_cell[point_i];
    if (ray % kOffsetOneIn != 0 || ray < 0 || storage_i < 0 || !(m.point_slope[point_i] < 0.0f))
      return;
    const float ground_m = m.cell.ground_m[storage_i], top_m = m.cell.elevation_m[storage_i];
    const bool bare = (m.cell.state[storage_i] == kMeasured) &
                      ((m.cell.flags[storage_i] & kWasPassable) != 0) &
                      !was_driven_through(m.cell.driven_height[storage_i]) &
                      !(top_m - ground_m > kBare_steps * m.k.step_threshold_m);
    if (bare) add(m.point_height_m[point_i] - m.datum->offset_m - ground_m);
  }

 private:
  TALUS_HD void add(float above_m) const
  {
    const float half = 0.5f * static_cast<float>(OffsetHistogram::kBins);
    const float bin = above_m / kOffsetBin_m + half;
    if (!(bin >= 0.0f && bin < 2.0f * half))
    {
      Atomics::add(&m.offsets->far, 1);
      return;
    }
    const int at = floor_to_int(bin);
    Atomics::add(m.offsets->count + at, 1);
    Atomics::add(
        m.offsets->sum + at, static_cast<std::uint32_t>(floor_to_int(above_m * kHeightUnits)));
  }
};

/** Evaluates and clears the histogram, and sets the datum; by a whole group, once in a frame. */
struct FollowPoses
{
  const Map& m;

  template <class Group>
  TALUS_HD void operator()(const Group& group) const
  {
    const Agreement best = agreement(group);
    const int far = static_cast<int>(m.offsets->far);
    group.sync();
    for (int bin = group.rank(); bin < OffsetHistogram::kBins; bin += group.size())
      m.offsets->count[bin] = m.offsets->sum[bin] = 0;
    if (group.rank() != 0) return;
    m.offsets->far = 0;
    decide(best, far);
    m.frame->drove_through_m = static_cast<float>(m.datum->drove_through) * kDrivenUnit_m;
    m.datum->drove_through = 0;
    m.frame->offset_m = m.datum->offset_m;
    m.frame->sensor_z_m = m.frame->sensor_z_map_m - m.datum->offset_m;
  }

 private:
  /** The three neighbouring bins with the most hits. */
  struct Agreement
  {
    int hits, sum, of;  //!< `of`: hits in all bins
  };

  TALUS_HD int hits_around(int bin) const
  {
    std::uint32_t hits = m.offsets->count[bin];
    if (bin > 0) hits += m.offsets->count[bin - 1];
    if (bin + 1 < OffsetHistogram::kBins) hits += m.offsets->count[bin + 1];
    return static_cast<int>(hits);
  }
  template <class Group>
  TALUS_HD Agreement agreement(const Group& group) const
  {
    int all = 0, max_hits = 0, where = -1;
    for (int bin = group.rank(); bin < OffsetHistogram::kBins; bin += group.size())
    {
      all += static_cast<int>(m.offsets->count[bin]);
      max_hits = max_of(max_hits, hits_around(bin));
    }
    max_hits = group.max(max_hits);
    for (int bin = group.rank(); bin < OffsetHistogram::kBins; bin += group.size())
      if (hits_around(bin) == max_hits) where = max_of(where, bin);
    where = group.max(where);
    std::uint32_t sum = 0;
    for (int bin = max_of(where - 1, 0); bin <= min_of(where + 1, OffsetHistogram::kBins - 1);
         bin++)
      sum += m.offsets->sum[bin];
    return {max_hits, static_cast<int>(sum), group.sum(all)};
  }

  TALUS_HD void decide(const Agreement& best, int far) const
  {
    Datum now = *m.datum;
    if (now.starts_anew != 0)
      now.offset_m = 0.0f, now.starts_anew = 0, m.frame->starts_map = 1;
    else if (const int all = best.of + far; all >= kMinGroundHits)
    {
      const float above_m =
          static_cast<float>(best.sum) / (static_cast<float>(best.hits) * kHeightUnits);
      const bool agree = 2 * best.hits > all && abs_of(above_m) > kFollow_m;
      if (agree && on(kFollowsPoses, m.k)) now.offset_m += above_m;
      const bool other_floor = (far >= kMinGroundHits) & (kOtherFloorOneIn * far > all);
      now.starts_anew = select(other_floor & on(kFollowsPoses, m.k), 1, 0);
    }
    *m.datum = now;
    m.counts->leaves_floor = static_cast<std::uint32_t>(now.starts_anew);
  }
};

struct ForgetHits
{
  const Map& m;

  TALUS_HD void operator()(int, int, int i) const { m.top_hit_m[i] = -kInfinity; }
};

/** Stage 2: the window follows the robot by whole cells. Storage is a torus, so that cells that
 * stay do not move. A cell that enters starts empty, and on another floor all cells do. */
struct RollCell
{
  const Map& m;

  TALUS_HD Stretch stays(int iy) const
  {
    return staying(*m.frame, m.k.cells, iy, m.datum->starts_anew != 0);
  }
  TALUS_HD bool applies(int ix, int iy, int) const { return !stays(iy).has(ix); }
  TALUS_HD void operator()(int, int, int i) const { m.cell.store(i, Cell{}); }
};

}  // namespace talus::kernels
