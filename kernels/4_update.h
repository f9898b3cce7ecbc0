#pragma once
#include "kernels/1_accept.h"
#include "kernels/3_roll.h"
#include "kernels/team.h"

namespace talus::kernels
{
// Stage 4 (III-B.1). The points of a cell in one frame are a set: every step below is a minimum, a
// maximum or an exact integer sum over them, so that their order cannot matter.

struct HeightPoint
{
  float height_m;
  float variance_m2;
  bool overhangs = false;  //!< a ray of its own direction passed below it and ended behind it
};

/** The points of one cell. */
struct CellPoints
{
  const HeightPoint* at;
  int size;
};

/** Eq. 5 as an innovation gate: the distance is measured in the deviation of cell and point
 * together. */
TALUS_HD bool inside_gate(float a_m, float var_a, float b_m, float var_b, const Config& k)
{
  const float d = a_m - b_m;
  return d * d <= k.gate2 * (var_a + var_b);
}

/** Points in order of their height, and of equal heights in that of `second`, as one integer. */
TALUS_HD std::int64_t order_key(float height_m, std::uint32_t second)
{
  return static_cast<std::int64_t>(ordered_from_float(height_m)) * 4294967296 + second;
}
TALUS_HD float height_of_key(std::int64_t key)
{
  return float_from_ordered(static_cast<std::int32_t>(key >> 32));
}

/** The ends of a set of points; of equal heights the point with the smaller variance. */
struct Extremes
{
  HeightPoint low, high;
};

template <class Team>
TALUS_HD Extremes extremes(const CellPoints& points, const Team& team)
{
  std::int64_t low = order_key(kInfinity, 0), high = order_key(-kInfinity, 0);
  for (int i = team.rank(); i < points.size; i += team.size())
  {
    const HeightPoint p = points.at[i];
    low = min_of(low, order_key(p.height_m, bits_of(p.variance_m2)));
    high = max_of(high, order_key(p.height_m, ~bits_of(p.variance_m2)));
  }
  low = team.min(low);
  high = team.max(high);
  return {
      {height_of_key(low), float_of_bits(static_cast<std::uint32_t>(low))},
      {height_of_key(high), float_of_bits(~static_cast<std::uint32_t>(high))}};
}

/** The highest point that is not above a limit, likewise. There is one. */
template <class Team>
TALUS_HD HeightPoint highest_up_to(const CellPoints& points, float limit_m, const Team& team)
{
  std::int64_t best = order_key(-kInfinity, 0);
  for (int i = team.rank(); i < points.size; i += team.size())
  {
    const HeightPoint p = points.at[i];
    if (p.height_m <= limit_m) best = max_of(best, order_key(p.height_m, ~bits_of(p.variance_m2)));
  }
  best = team.max(best);
  return {height_of_key(best), float_of_bits(~static_cast<std::uint32_t>(best))};
}

/** A height and its variance. */
struct Estimate
{
  float height_m;
  float variance_m2;
};

/** Kalman fusion (eq. 6 and 7, d <= c) of all points inside the gate around `base`, in one step:
 * the information of a set adds up. Sums are in integers: distances in 2^-20 m, information in 2^-8
 * / m^2. `base` itself takes part when it is a prior; a base that is one of the points is in the
 * set already. */
template <class Team>
TALUS_HD Estimate fuse(
    const Estimate& base, bool base_is_prior, const CellPoints& points, float limit_m,
    const Config& k, const Team& team)
{
  constexpr float kInformation = 256.0f, kDistance = 1048576.0f;
  const std::int64_t prior =
      base_is_prior ? static_cast<std::int64_t>(kInformation / base.variance_m2) : 0;
  std::int64_t information = 0, weighted_distance = 0;
  for (int i = team.rank(); i < points.size; i += team.size())
  {
    const HeightPoint p = points.at[i];
    if (p.height_m > limit_m ||
        !inside_gate(p.height_m, p.variance_m2, base.height_m, base.variance_m2, k))
      continue;
    const std::int64_t w = static_cast<std::int64_t>(kInformation / p.variance_m2) + 1;
    information += w;
    weighted_distance += w * static_cast<std::int64_t>((p.height_m - base.height_m) * kDistance);
  }
  information = prior + team.sum(information);
  weighted_distance = team.sum(weighted_distance);
  if (information == prior) return base;  // nothing inside the gate
  const float shift =
      static_cast<float>(static_cast<double>(weighted_distance) / static_cast<double>(information));
  const float variance = kInformation / static_cast<float>(information);
  return {base.height_m + shift / kDistance, max_of(variance, k.min_variance_m2)};
}

/** The ground keeps the lowest: what is inside the gate is fused, what is lower replaces, what is
 * higher is no ground. Ground that was only filled gives way to any measurement, except that what
 * stands more than a step above a reliable fill is an object on it. */
template <class Team>
TALUS_HD void update_ground(
    Cell& c, const HeightPoint& low, const CellPoints& points, const Config& k, const Team& team)
{
  const bool measured = c.state == kMeasured;
  if (c.state == kFilledTwoSided && low.height_m > c.ground_m + k.step_threshold_m) return;
  const bool fused =
      measured && (low.height_m >= c.ground_m ||
                   inside_gate(low.height_m, low.variance_m2, c.ground_m, c.ground_var_m2, k));
  const Estimate base =
      fused ? Estimate{c.ground_m, c.ground_var_m2} : Estimate{low.height_m, low.variance_m2};
  const Estimate ground = fuse(base, fused, points, kInfinity, k, team);
  // What stood on the old ground stands on the new one only if the robot does not fit between.
  const bool hangs = measured && c.ground_m - ground.height_m > k.clearance_m;
  if (hangs) c.elevation_m = c.elevation_var_m2 = kNan;
  c.ground_m = ground.height_m;
  c.ground_var_m2 = ground.variance_m2;
  c.state = kMeasured;
}

/** Climbs from the ground (or from what stands on it) over the points; at the first gap larger than
 * the robot's clearance all that is above hangs and is passable. Returns the height of the last
 * point below that gap. */
template <class Team>
TALUS_HD float top_of_standing(
    float start_m, float highest_m, const CellPoints& points, const Config& k, const Team& team)
{
  float top = start_m;
  while (top < highest_m)
  {
    float next = top;
    for (int i = team.rank(); i < points.size; i += team.size())
    {
      const float z = points.at[i].height_m;
      if (z > next && z <= top + k.clearance_m) next = z;
    }
    next = team.max(next);
    if (next == top) break;
    top = next;
  }
  return top;
}

/** The elevation keeps the highest of what stands (eq. 6 and 7): inside the gate it is fused, a
 * higher point replaces it, a lower one leaves height and variance as they are. */
template <class Team>
TALUS_HD void update_elevation(
    Cell& c, const HeightPoint& highest, const CellPoints& points, const Config& k,
    const Team& team)
{
  const bool has_elevation = is_known(c.elevation_m);
  const float start = has_elevation ? max_of(c.ground_m, c.elevation_m) : c.ground_m;
  const float top = top_of_standing(start, highest.height_m, points, k, team);
  const HeightPoint high = top < highest.height_m ? highest_up_to(points, top, team) : highest;
  const bool fused =
      has_elevation &&
      inside_gate(high.height_m, high.variance_m2, c.elevation_m, c.elevation_var_m2, k);
  if (has_elevation && !fused && high.height_m < c.elevation_m) return;
  const Estimate base = fused ? Estimate{c.elevation_m, c.elevation_var_m2}
                              : Estimate{high.height_m, high.variance_m2};
  const Estimate elevation = fuse(base, fused, points, top, k, team);
  c.elevation_m = elevation.height_m;
  c.elevation_var_m2 = elevation.variance_m2;
}

/** Over a guess below which no ray passed it is not known what hangs: a wall may be hit high up
 * first. It stands until a ray passes there. */
TALUS_HD void hit_high_up(Cell& c, const HeightPoint& high)
{
  if ((c.passed & kHitHighUp) && c.elevation_m >= high.height_m) return;
  c.elevation_m = high.height_m;
  c.elevation_var_m2 = high.variance_m2;
  c.passed = static_cast<std::uint8_t>(c.passed | kHitHighUp);
}

/** Stage 4 on one cell that received points. */
template <class Team>
TALUS_HD void update_cell(
    Cell& c, const Extremes& ends, const CellPoints& points, const Config& k, const Team& team)
{
  if (c.state != kUnknown)
  {
    const bool stands = is_known(c.elevation_m) && !(c.passed & kHitHighUp);
    const float standing = stands ? max_of(c.ground_m, c.elevation_m) : c.ground_m;
    if (ends.low.height_m - standing > k.clearance_m)
    {
      if (!stands && c.state == kFilledOneSided && !(c.passed & kPassedLow))
        hit_high_up(c, ends.high);
      return;  // all of it hangs
    }
  }
  c.passed = static_cast<std::uint8_t>(c.passed & ~kHitHighUp);
  update_ground(c, ends.low, points, k, team);
  update_elevation(c, ends.high, points, k, team);
  c.elevation_m = max_of(c.elevation_m, c.ground_m);
}

/** Where the points of each cell stand after sorting. Which stretch a cell gets does not matter. */
struct Sorting
{
  const std::uint32_t* cell_count;  //!< of points that a stretch has room for
  const std::uint32_t* kept_count;  //!< of points that are in it
  std::uint32_t* cell_begin;
  HeightPoint* sorted;
  std::int32_t* crowded;  //!< cells that a team updates
  std::uint64_t* cursor;  //!< of `sorted`, and in the upper half of `crowded`; zero before
  std::uint32_t crowd;  //!< cells of more points are crowded
};

/** Reserves a stretch for the cell of a point, if it is the first there. */
template <class Atomics>
struct ReserveStretch
{
  const FrameContext* frame;
  PointsOut points;
  Sorting sorting;

  TALUS_HD void operator()(int i) const
  {
    if (i >= frame->n_points || points.cell[i] < 0 || points.rank[i] != 0) return;
    const int cell = points.cell[i];
    const std::uint64_t count = sorting.cell_count[cell];
    const bool crowded = count > sorting.crowd;
    const std::uint64_t at = Atomics::reserve(sorting.cursor, crowded ? count | 1ull << 32 : count);
    sorting.cell_begin[cell] = static_cast<std::uint32_t>(at);
    if (crowded) sorting.crowded[at >> 32] = cell;
  }
};

/** Moves one point to the stretch of its cell. */
struct SortPoint
{
  const Config* config;
  const FrameContext* frame;
  PointsOut points;
  const std::int32_t* rays;
  Sorting sorting;

  /** Whether rays of its own direction passed below a point. Beside the edge of something rays pass
   * as well; below what overhangs they pass on both sides of the point. */
  TALUS_HD bool overhangs(int i) const
  {
    const bool aims = points.ray[i] >= 0;
    const int at = select(aims, points.ray[i], 0), bins = bin_count(*config);
    const int ring = floor_div(at, bins, 1.0f / static_cast<float>(bins)), bin = at - ring * bins;
    const std::int32_t* behind = rays + min_of(ring + 2, ring_count(*config) - 1) * bins;
    const float chebyshev_m = (static_cast<float>(ring) + 0.5f) * config->resolution_m;
    const float limit = points.slope[i] - config->cleanup_margin_m / chebyshev_m;
    bool below = aims;
    for (int b = -2; b <= 2; b++)
    {
      const std::int32_t passed = behind[wrap_bin(bin + b, bins)];
      below = below & (passed != kNoRay) & !(float_from_ordered(passed) > limit);
    }
    return below;
  }

  /** As the point of that rank. */
  TALUS_HD void put(int i, std::uint32_t rank, bool overhangs) const
  {
    sorting.sorted[sorting.cell_begin[points.cell[i]] + rank] = {
        points.height_m[i], points.variance_m2[i], overhangs};
  }

  /** As the point of the rank that it has. */
  TALUS_HD void put(int i, bool overhangs) const
  {
    if (i < frame->n_points && points.cell[i] >= 0) put(i, points.rank[i], overhangs);
  }
};

/** The same where points were counted before it was known which are buried: leaves those out. */
template <class Atomics>
struct SortUnburiedPoint
{
  SortPoint sort;
  const float* lowest_slope;  //!< of a ray that is not buried
  std::uint32_t* kept_count;  //!< by storage index, zero before
  std::uint32_t* rejected;  //!< by RejectCode

  TALUS_HD void operator()(int i) const
  {
    const PointsOut& points = sort.points;
    if (i >= sort.frame->n_points || points.cell[i] < 0) return;
    const int ray = points.ray[i];
    if (ray >= 0 && points.slope[i] < lowest_slope[ray])
      Atomics::count(rejected + kBuried);
    else
      sort.put(i, Atomics::add(kept_count + points.cell[i], 1), sort.overhangs(i));
  }
};

/** Stage 4 on the cell of a point, if it is the first there, or on a crowded cell. */
struct UpdateCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  PointsOut points;
  Sorting sorting;
  float* top_hit_m;

  template <class Team>
  TALUS_HD void operator()(int slot, const Team& team) const
  {
    const int cell = crowded_cell(slot);
    if (cell >= 0) update(cell, team);
  }
  /** The cell that is to be updated for point i, or -1. */
  TALUS_HD int lone_cell(int i) const
  {
    if (i >= frame->n_points || points.cell[i] < 0 || points.rank[i] != 0) return -1;
    return sorting.cell_count[points.cell[i]] <= sorting.crowd ? points.cell[i] : -1;
  }
  /** A crowded cell, or -1: there are no more. */
  TALUS_HD int crowded_cell(int slot) const
  {
    return slot < static_cast<int>(*sorting.cursor >> 32) ? sorting.crowded[slot] : -1;
  }

  template <class Team>
  TALUS_HD void update(int i, const Team& team) const
  {
    const CellPoints here{
        sorting.sorted + sorting.cell_begin[i], static_cast<int>(sorting.kept_count[i])};
    if (here.size == 0) return;
    Cell c = store.load(i);
    const Extremes ends = extremes(here, team);
    update_cell(c, ends, here, *config, team);
    std::int32_t overhangs = 0;
    for (int p = team.rank(); p < here.size; p += team.size())
      overhangs |= here.at[p].overhangs && here.at[p].height_m <= c.ground_m + config->clearance_m;
    if (team.max(overhangs)) c.misses = -kMaxCredit;
    if (team.rank() != 0) return;
    store.store(i, c);
    top_hit_m[i] = ends.high.height_m;
  }
};

}  // namespace talus::kernels
