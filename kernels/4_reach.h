#pragma once
#include "kernels/4_underfoot.h"
#include "kernels/map.h"

namespace talus::kernels
{
// Stage 4 (III-B.4): ground is what the robot can get to. All of this works on pairs of cells:
//   1. A pair is passable if stage 7 gave each of its cells half a score in the last frame.
//   2. The pair below the robot is reached.
//   3. A passable pair is reached if it was before, or if one beside it is. Four sweeps a frame,
//      along columns and rows and back, cross the window.
//   4. What was passable, is not reached and lies higher than the robot can climb from reached
//      ground around it is the top of an object, as the roof of a car (4_classify.h).
//   5. Measured "ground" is an object, too, if it is both narrow and steep, as the lowest hit on a
//      wall. Narrow: it lies above the morphological opening of the ground, since nothing as wide
//      as object_size_m fits below its top. Of reached ground only what is reached counts, so that
//      a ditch does not make a bridge narrow. Steep: it lies above a cone of the steepest slope
//      over ground close by, so that a ridge or a bank is no object.

/** Pools the cells of a pair, see PoolReach. */
template <class Pool>
TALUS_HD typename Pool::Item pool_pair(const Pool& f, const Map& m, int px, int py)
{
  const int x0 = m.pairs.first_cell(px, m.frame->odd_x);
  const int y0 = m.pairs.first_cell(py, m.frame->odd_y);
  const auto cell = [&](int x, int y)
  { return m.has(x, y) ? f.item(m.at(x, y)) : typename Pool::Item{}; };
  return f.pool(
      f.pool(cell(x0, y0), cell(x0, y0 + 1)), f.pool(cell(x0 + 1, y0), cell(x0 + 1, y0 + 1)));
}

struct PairReach
{
  std::int32_t is = kOutsideWindow;
};

struct PoolReach
{
  using Item = PairReach;
  const Map& m;

  TALUS_HD PairReach item(int i) const
  {
    const std::int32_t flags = m.cell.flags[i];
    return {(flags & kWasPassable) * (1 + (flags & kWasReached) / kWasReached)};
  }
  TALUS_HD PairReach pool(const PairReach& a, const PairReach& b) const
  {
    const std::int32_t low = min_of(a.is, b.is);
    return {select(low == kPairBlocked, low, max_of(a.is, b.is))};
  }
  TALUS_HD void put(int px, int py, const PairReach& pooled) const
  {
    const bool starts = is_below_robot(px, py) & on(kReach, m.k);
    m.pair_reach[m.pairs.at(px, py)] = select(starts, static_cast<int>(kPairReached), pooled.is);
  }
  TALUS_HD void operator()(int px, int py) const { put(px, py, pool_pair(*this, m, px, py)); }

 private:
  TALUS_HD bool is_below_robot(int px, int py) const
  {
    const float x_m =
        static_cast<float>(m.pairs.first_cell(px, m.frame->odd_x) + 1) * m.k.resolution_m;
    const float y_m =
        static_cast<float>(m.pairs.first_cell(py, m.frame->odd_y) + 1) * m.k.resolution_m;
    const Offset at{x_m - m.frame->base_x_m, y_m - m.frame->base_y_m};
    return at.is_within(kFootprint_m) & (m.frame->n_points > 0);
  }
};

/** Carries the reach from pair to pair. Lines of one direction do not need each other. */
template <bool kColumns>
struct SpreadReach
{
  const Map& m;

  TALUS_HD void operator()(int first, int end) const
  {
    if constexpr (kColumns)
      along_columns(first, end);
    else
      along_rows(first, end);
  }

 private:
  TALUS_HD void along_rows(int first, int end) const
  {
    for (int py = first; py < end; py++)
    {
      std::int32_t* const row = m.pair_reach + m.pairs.at(0, py);
      if (!spreads(row)) continue;
      for (int px = 1; px < m.pairs.side; px++) row[px] = spread(row[px - 1], row[px]);
      for (int px = m.pairs.side - 1; px-- > 0;) row[px] = spread(row[px + 1], row[px]);
    }
  }
  /** The columns are side by side. */
  TALUS_HD void along_columns(int first, int end) const
  {
    for (int py = 1; py < m.pairs.side; py++) from_row(py - 1, py, first, end);
    for (int py = m.pairs.side - 1; py-- > 0;) from_row(py + 1, py, first, end);
  }
  static TALUS_HD std::int32_t spread(std::int32_t from, std::int32_t to)
  {
    return select((from == kPairReached) & (to == kPairPassable), from, to);
  }
  /** Whether a reached pair is beside a passable one: after the columns it seldom is. */
  TALUS_HD bool spreads(const std::int32_t* row) const
  {
    std::int32_t any = 0;
    for (int px = 1; px < m.pairs.side; px++)
      any |= static_cast<std::int32_t>(row[px - 1] + row[px] == kPairReached + kPairPassable);
    return any != 0;
  }
  TALUS_HD void from_row(int from, int to, int first, int end) const
  {
    const std::int32_t* const a = m.pair_reach + m.pairs.at(0, from);
    std::int32_t* const b = m.pair_reach + m.pairs.at(0, to);
    for (int px = first; px < end; px++) b[px] = spread(a[px], b[px]);
  }
};

struct CoarseCell
{
  float lowest_m = kInfinity, known_m = kInfinity, column_m = -kInfinity, thing_m = -kInfinity;
  std::int32_t presence = kEmpty;  //!< the highest Presence
};

struct PoolCells
{
  using Item = CoarseCell;
  const Map& m;

  TALUS_HD CoarseCell item(int i) const
  {
    const float ground = m.cell.ground_m[i], top = m.cell.elevation_m[i];
    const bool measured = m.cell.state[i] == kMeasured;
    const bool upright = measured & (top - ground > kUpright_steps * m.k.step_threshold_m);
    const bool stands = top > bare_up_to_m(ground, m.k);
    const bool blocks = top - ground > m.k.step_threshold_m;
    const int bare = select(object_left(m.cell.recent_hits[i]), kLeft, kEmpty);
    return {
        select(measured, ground, kInfinity), select(is_known(ground), ground, kInfinity),
        select(upright, top, -kInfinity), select(blocks, top, -kInfinity),
        select(stands, kStands, bare)};
  }
  TALUS_HD CoarseCell pool(const CoarseCell& a, const CoarseCell& b) const
  {
    return {
        min_of(a.lowest_m, b.lowest_m), min_of(a.known_m, b.known_m),
        max_of(a.column_m, b.column_m), max_of(a.thing_m, b.thing_m),
        max_of(a.presence, b.presence)};
  }
  TALUS_HD void put(int px, int py, const CoarseCell& pooled) const
  {
    m.pair_lowest_m[m.pairs.at(px, py)] = pooled.lowest_m;
    m.pair_known_m[m.pairs.at(px, py)] = pooled.known_m;
    m.pair_column_m[m.pairs.at(px, py)] = pooled.column_m;
    m.pair_thing_m[m.pairs.at(px, py)] = pooled.thing_m;
    m.pair_presence[m.pairs.at(px, py)] = static_cast<float>(pooled.presence);
  }
  TALUS_HD void operator()(int px, int py) const { put(px, py, pool_pair(*this, m, px, py)); }
};

/** The ground of a neighbourhood: the lowest, and the same raised with distance; the lowest that is
 * reached, and the same raised with distance; and the highest top beside it. */
struct NearGround
{
  float lowest_m = kInfinity, cone_m = kInfinity;
  float low_reached_m = kInfinity, reached_cone_m = kInfinity, thing_m = -kInfinity;
};

struct ErodeGround
{
  using Row = NearGround;
  using Window = NearGround;
  static constexpr bool kHasPlain = false;
  const Map& m;

  TALUS_HD const float& neighbour(int px, int py) const
  {
    return m.pair_lowest_m[m.pairs.at(px, py)];
  }
  TALUS_HD void add(NearGround& row, int px, int py, int d) const
  {
    const float ground_m = neighbour(px + d, py), known_m = m.pair_known_m[m.pairs.at(px + d, py)];
    const float reached_m = select(is_reached(px + d, py), known_m, kInfinity);
    const float thing_m = m.pair_thing_m[m.pairs.at(px + d, py)];
    add(row, {ground_m, ground_m, reached_m, reached_m, thing_m}, d);
  }
  TALUS_HD void add(NearGround& sum, const NearGround& other, int d) const
  {
    const float away_m = 2.0f * m.k.resolution_m * static_cast<float>(abs_of(d));
    const float steepest = max_of(m.k.max_slope, kSteepestBank);
    sum.lowest_m = min_of(sum.lowest_m, other.lowest_m);
    sum.cone_m = min_of(sum.cone_m, other.cone_m + steepest * away_m);
    sum.low_reached_m = min_of(sum.low_reached_m, other.low_reached_m);
    sum.reached_cone_m = min_of(sum.reached_cone_m, other.reached_cone_m + m.k.max_slope * away_m);
    const bool beside = away_m <= kBesideThing_m;
    sum.thing_m = max_of(sum.thing_m, select(beside, other.thing_m, -kInfinity));
  }

  TALUS_HD void operator()(int px, int py, const NearGround& near) const
  {
    const int coarse_i = m.pairs.at(px, py);
    const float lowest_m = select(is_reached(px, py), near.low_reached_m, near.lowest_m);
    m.pair_eroded_m[coarse_i] = select(may_be_wide(px, py), lowest_m, kInfinity);
    m.pair_cone_m[coarse_i] = near.cone_m;
    m.pair_apart_m[coarse_i] = near.reached_cone_m + kApart_steps * m.k.step_threshold_m;
    m.pair_foot_m[coarse_i] = near.low_reached_m;
    m.pair_beside_m[coarse_i] = select(near.thing_m > -kInfinity, near.thing_m, kInfinity);
  }

 private:
  TALUS_HD bool is_reached(int px, int py) const
  {
    return m.pair_reach[m.pairs.at(px, py)] == kPairReached;
  }
  /** Known ground with nothing upright near it: no face, none of its edges, nothing behind it. */
  TALUS_HD bool may_be_wide(int px, int py) const
  {
    bool any = false;
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++)
      {
        const int y = min_of(max_of(py + dy, 0), m.pairs.side - 1);
        const float column_m = m.pair_column_m[m.pairs.at(px + dx, y)];
        any |= (column_m > -kInfinity) & (column_m < kInfinity);
      }
    return !any & (m.pair_lowest_m[m.pairs.at(px, py)] < kInfinity);
  }
};

/** Highest eroded ground of a neighbourhood; pairs without any ground do not count. */
struct HighestGround
{
  float height_m = -kInfinity;
};

/** Dilation of the eroded ground: finds how high ground can be. Near upright objects the lowest hit
 * is the ground only where wide ground goes on from there, if there is any. */
struct OpenGround
{
  using Row = HighestGround;
  using Window = HighestGround;
  static constexpr bool kHasPlain = false;
  const Map& m;

  TALUS_HD const float& neighbour(int px, int py) const
  {
    return m.pair_eroded_m[m.pairs.at(px, py)];
  }
  TALUS_HD void add(HighestGround& row, int px, int py, int d) const
  {
    const float eroded_m = neighbour(px + d, py);
    row.height_m = max_of(row.height_m, select(eroded_m < kInfinity, eroded_m, -kInfinity));
  }
  TALUS_HD void add(HighestGround& sum, const HighestGround& other, int) const
  {
    sum.height_m = max_of(sum.height_m, other.height_m);
  }

  TALUS_HD void operator()(int px, int py, const HighestGround& opened) const
  {
    const int coarse_i = m.pairs.at(px, py);
    const float by_cone_m = m.pair_cone_m[coarse_i] + kAboveCone_steps * m.k.step_threshold_m;
    const float by_width_m = opened.height_m + kAboveOpening_steps * m.k.step_threshold_m;
    const bool by_width = (m.pair_eroded_m[coarse_i] == kInfinity) & (opened.height_m > -kInfinity);
    m.pair_limit_m[coarse_i] = max_of(select(by_width, -kInfinity, by_cone_m), by_width_m);
  }
};

}  // namespace talus::kernels
