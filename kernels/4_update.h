#pragma once
#include "kernels/1_accept.h"
#include "kernels/3_roll.h"

namespace talus::kernels
{
// Stage 4 (III-B.1). The points of a cell in one frame are a set: every step below is a minimum, a
// maximum or an exact integer sum over them, so that their order cannot matter.

struct HeightPoint
{
  float height_m;
  float variance_m2;
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

/** The lowest point; of equal heights the one with the smaller variance. */
TALUS_HD HeightPoint lowest(const CellPoints& points)
{
  HeightPoint best = points.at[0];
  for (int i = 1; i < points.size; i++)
  {
    const HeightPoint p = points.at[i];
    if (p.height_m < best.height_m ||
        (p.height_m == best.height_m && p.variance_m2 < best.variance_m2))
      best = p;
  }
  return best;
}

/** The highest point that is not above a limit, likewise. There is one. */
TALUS_HD HeightPoint highest_up_to(const CellPoints& points, float limit_m)
{
  HeightPoint best{-kInfinity, kInfinity};
  for (int i = 0; i < points.size; i++)
  {
    const HeightPoint p = points.at[i];
    if (p.height_m <= limit_m && (p.height_m > best.height_m || (p.height_m == best.height_m &&
                                                                 p.variance_m2 < best.variance_m2)))
      best = p;
  }
  return best;
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
TALUS_HD Estimate fuse(
    const Estimate& base, bool base_is_prior, const CellPoints& points, float limit_m,
    const Config& k)
{
  constexpr float kInformation = 256.0f, kDistance = 1048576.0f;
  std::int64_t information =
      base_is_prior ? static_cast<std::int64_t>(kInformation / base.variance_m2) : 0;
  const std::int64_t prior = information;
  std::int64_t weighted_distance = 0;
  for (int i = 0; i < points.size; i++)
  {
    const HeightPoint p = points.at[i];
    if (p.height_m > limit_m ||
        !inside_gate(p.height_m, p.variance_m2, base.height_m, base.variance_m2, k))
      continue;
    const std::int64_t w = static_cast<std::int64_t>(kInformation / p.variance_m2) + 1;
    information += w;
    weighted_distance += w * static_cast<std::int64_t>((p.height_m - base.height_m) * kDistance);
  }
  if (information == prior) return base;  // nothing inside the gate
  const float shift =
      static_cast<float>(static_cast<double>(weighted_distance) / static_cast<double>(information));
  const float variance = kInformation / static_cast<float>(information);
  return {base.height_m + shift / kDistance, max_of(variance, k.min_variance_m2)};
}

/** The ground keeps the lowest: what is inside the gate is fused, what is lower replaces, what is
 * higher is no ground. Ground that was only filled gives way to any measurement, except that what
 * stands more than a step above a reliable fill is an object on it. */
TALUS_HD void update_ground(
    Cell& c, const HeightPoint& low, const CellPoints& points, const Config& k)
{
  const bool measured = c.state == kMeasured;
  if (c.state == kFilledTwoSided && low.height_m > c.ground_m + k.step_threshold_m) return;
  const bool fused =
      measured && (low.height_m >= c.ground_m ||
                   inside_gate(low.height_m, low.variance_m2, c.ground_m, c.ground_var_m2, k));
  const Estimate base =
      fused ? Estimate{c.ground_m, c.ground_var_m2} : Estimate{low.height_m, low.variance_m2};
  const Estimate ground = fuse(base, fused, points, kInfinity, k);
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
TALUS_HD float top_of_standing(float start_m, const CellPoints& points, const Config& k)
{
  float top = start_m;
  for (;;)
  {
    float next = top;
    for (int i = 0; i < points.size; i++)
    {
      const float z = points.at[i].height_m;
      if (z > next && z <= top + k.clearance_m) next = z;
    }
    if (next == top) return top;
    top = next;
  }
}

/** The elevation keeps the highest of what stands (eq. 6 and 7): inside the gate it is fused, a
 * higher point replaces it, a lower one leaves height and variance as they are. */
TALUS_HD void update_elevation(Cell& c, const CellPoints& points, const Config& k)
{
  const bool has_elevation = is_known(c.elevation_m);
  const float start = has_elevation ? max_of(c.ground_m, c.elevation_m) : c.ground_m;
  const float top = top_of_standing(start, points, k);
  const HeightPoint high = highest_up_to(points, top);
  const bool fused =
      has_elevation &&
      inside_gate(high.height_m, high.variance_m2, c.elevation_m, c.elevation_var_m2, k);
  if (has_elevation && !fused && high.height_m < c.elevation_m) return;
  const Estimate base = fused ? Estimate{c.elevation_m, c.elevation_var_m2}
                              : Estimate{high.height_m, high.variance_m2};
  const Estimate elevation = fuse(base, fused, points, top, k);
  c.elevation_m = elevation.height_m;
  c.elevation_var_m2 = elevation.variance_m2;
}

/** Stage 4 on one cell that received points. */
TALUS_HD void update_cell(Cell& c, const CellPoints& points, const Config& k)
{
  const HeightPoint low = lowest(points);
  if (c.state != kUnknown)
  {
    const float standing = is_known(c.elevation_m) ? max_of(c.ground_m, c.elevation_m) : c.ground_m;
    if (low.height_m - standing > k.clearance_m) return;  // all of it hangs
  }
  update_ground(c, low, points, k);
  update_elevation(c, points, k);
  c.elevation_m = max_of(c.elevation_m, c.ground_m);
}

/** Reserves a stretch of the sorted points for each cell; which one does not matter. */
template <class Atomics>
struct ReserveCellPoints
{
  const std::uint32_t* cell_count;
  std::uint32_t* cell_begin;
  std::uint32_t* cursor;  //!< zero before

  TALUS_HD void operator()(int i) const
  {
    if (cell_count[i]) cell_begin[i] = Atomics::add(cursor, cell_count[i]);
  }
};

/** Moves one point to the stretch of its cell. */
struct SortPoint
{
  const FrameContext* frame;
  PointsOut points;
  const std::uint32_t* cell_begin;
  HeightPoint* sorted;

  TALUS_HD void operator()(int i) const
  {
    if (i >= frame->n_points || points.cell[i] < 0) return;
    sorted[cell_begin[points.cell[i]] + points.rank[i]] = {
        points.height_m[i], points.variance_m2[i]};
  }
};

/** Stages 3 and 4 on cell (ix, iy) of the window. Leaves cell_count at zero for the next frame. */
struct UpdateCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  std::uint32_t* cell_count;
  const std::uint32_t* cell_begin;
  const HeightPoint* sorted;
  float* top_hit_m;  //!< by storage index: highest point of this frame; -infinity: none

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int i = storage_index(*frame, config->cells, ix, iy);
    const int count = static_cast<int>(cell_count[i]);
    const bool entered = entered_window(*frame, config->cells, ix, iy);
    top_hit_m[i] = -kInfinity;
    if (!count && !entered) return;
    Cell c;
    if (!entered) c = store.load(i);
    if (count)
    {
      const CellPoints points{sorted + cell_begin[i], count};
      update_cell(c, points, *config);
      top_hit_m[i] = highest_up_to(points, kInfinity).height_m;
      cell_count[i] = 0;
    }
    store.store(i, c);
  }
};

}  // namespace talus::kernels
