#pragma once
#include "kernels/rays.h"

#include <tuple>

namespace talus::kernels
{
// Stage 6 (III-B.2): cells that this frame did not touch, but whose surface stands above a ray that
// went on behind it, are cleared down to their ground. Stage 1 has turned the hits of each ring
// into the lowest ray that passed it: each cell is a look-up. The same table bounds unseen ground
// from above.

/** What the rays of this frame say of one cell. */
struct SeenThrough
{
  float lowest_m = kInfinity;  //!< lowest height at which a ray passed
  float highest_m = -kInfinity;  //!< the highest among the lowest rays of the cell's directions;
                                 //!< bounds unseen ground from above
  std::int32_t in_open = 1;  //!< nothing was hit between the sensor and the cell
  TALUS_HD bool any() const { return lowest_m < kInfinity; }

  static constexpr auto fields()
  {
    return std::make_tuple(&SeenThrough::lowest_m, &SeenThrough::highest_m, &SeenThrough::in_open);
  }
};

constexpr int kMaxBinsPerCellBits = 3;  //!< of a cell near the sensor eight are looked at

/** Where the rays through the middle half of the angle under which the sensor sees a cell are
 * found, those that ended two or more rings behind it. */
struct Glance
{
  std::int32_t first_bin = 0, last_bin = -1, stride = 1;
  std::int32_t row = 0;  //!< where their ring starts in the table
  float chebyshev_m = 0;

  static constexpr auto fields()
  {
    return std::make_tuple(
        &Glance::first_bin, &Glance::last_bin, &Glance::stride, &Glance::row, &Glance::chebyshev_m);
  }
  /** How many rays to look at. */
  TALUS_HD int rays() const
  {
    const int more = floor_div(last_bin - first_bin, stride, 1.0f / static_cast<float>(stride));
    return select(last_bin < first_bin, 0, more + 1);
  }
};

TALUS_HD Glance glance_at(const Config& k, const FrameContext& f, int ix, int iy)
{
  const float dx = (static_cast<float>(ix) + 0.5f) * k.resolution_m - f.sensor_x_m;
  const float dy = (static_cast<float>(iy) + 0.5f) * k.resolution_m - f.sensor_y_m;
  Glance g;
  g.chebyshev_m = chebyshev(dx, dy);
  const float ring = g.chebyshev_m * k.inverse_resolution;
  const bool under_sensor = ring < 2.0f;
  const int bins = bin_count(k), per_side = bins_per_side(k);
  g.row = min_of(floor_to_int(ring) + 2, ring_count(k) - 1) * bins;
  const float half_span = 0.125f * static_cast<float>(per_side) / select(under_sensor, 2.0f, ring);
  const float middle =
      direction_in_bins(select(under_sensor, 1.0f, dx), select(under_sensor, 0.0f, dy), per_side);
  g.first_bin = floor_to_int(middle - half_span);
  g.last_bin = select(under_sensor, g.first_bin - 1, floor_to_int(middle + half_span));
  g.stride = (max_of(g.last_bin - g.first_bin, 0) >> kMaxBinsPerCellBits) + 1;
  return g;
}

/** Looks at one of them. Heights are taken where the ray is highest inside the cell. */
TALUS_HD void look(
    SeenThrough& seen, const Glance& g, int which, const Config& k, const FrameContext& f,
    const std::int32_t* rays)
{
  const int bin = g.first_bin + which * g.stride;
  const bool wanted = bin <= g.last_bin;
  const int column = select(wanted, wrap_bin(bin, bin_count(k)), 0);
  const std::int32_t hit = rays[g.row + column], anywhere = rays[column];
  seen.in_open = select(wanted & (hit != anywhere), 0, seen.in_open);
  const bool passed = wanted & (hit != kNoRay);
  const float slope = float_from_ordered(hit);
  const float half_cell = 0.5f * k.resolution_m;
  const float where = g.chebyshev_m + select(slope < 0.0f, -half_cell, half_cell);
  const float height = f.sensor_z_m + slope * where;
  seen.lowest_m = min_of(seen.lowest_m, select(passed, height, kInfinity));
  seen.highest_m = max_of(seen.highest_m, select(passed, height, -kInfinity));
}

/** How far the rays of this frame went, see NoteReach. */
struct Reach
{
  const FrameContext* frame;
  const std::int32_t* of_slope;
};

/** Rays are looked at in so many directions more on either side of a cell: beside the edge of what
 * stands there some go on. */
constexpr int kBesideCell = 2;

/** Whether rays that aimed at a cell between `low_m` and `high_m` ended two or more rings behind
 * it, and none before. */
TALUS_HD bool went_between(
    float low_m, float high_m, const Glance& g, const Config& k, const Reach& reach)
{
  const int rays = g.rays(), bins = bin_count(k);
  if (rays == 0) return false;
  const float sensor_m = reach.frame->sensor_z_m, at_m = g.chebyshev_m;
  const float low = slope_step(ray_slope(low_m - sensor_m, at_m));
  const float high = slope_step(ray_slope(high_m - sensor_m, at_m));
  const int first = max_of(floor_to_int(low) + 1, 0), end = min_of(floor_to_int(high), kSlopeSteps);
  bool any = false;
  for (int which = -kBesideCell; which < rays + kBesideCell; which++)
  {
    const int bin = wrap_bin(g.first_bin + which * g.stride, bins);
    for (int step = first; step < end; step++)
    {
      const int ray = -reach.of_slope[step * bins + bin];
      if (ray > 0 && ray < g.row) return false;
      any = any || ray > 0;
    }
  }
  return any;
}

/** From a height that was hit in a cell to the end of the hits below or above it in one direction,
 * up to a ray that went on. Hits up to two rings before the cell and one behind it count: what
 * overhangs is seldom one cell wide. */
TALUS_HD float end_of_hits(
    float hit_m, bool above, int bin, const Glance& g, const Config& k, const Reach& reach)
{
  const int bins = bin_count(k), nearest = g.row - 4 * bins, up = select(above, 1, -1);
  const float sensor_m = reach.frame->sensor_z_m, at_m = g.chebyshev_m;
  float end_m = hit_m;
  int step = floor_to_int(slope_step(ray_slope(hit_m - sensor_m, at_m))) + select(above, 1, 0);
  for (; step >= 0 && step < kSlopeSteps; step += up)
  {
    const int ray = -reach.of_slope[step * bins + bin];
    if (ray == 0) continue;
    if (ray < nearest || ray >= g.row) break;
    end_m = sensor_m + slope_of_step(step) * at_m;
  }
  return end_m;
}

/** Of a cell that was hit: not lower than `limit_m`, where rays passed. The top may have risen to
 * this hit, so that what was known above it holds no more. */
TALUS_HD void put_extent(
    Cell& c, float top_m, float hit_m, float limit_m, const Glance& g, const Config& k,
    const Reach& reach)
{
  float low_m = hit_m, high_m = hit_m;
  for (int which = 0; which < g.rays(); which++)
  {
    const int bin = wrap_bin(g.first_bin + which * g.stride, bin_count(k));
    low_m = min_of(low_m, end_of_hits(hit_m, false, bin, g, k, reach));
    high_m = max_of(high_m, end_of_hits(hit_m, true, bin, g, k, reach));
  }
  const bool at_top = hit_m >= top_m - k.cleanup_margin_m;
  const int above_before = select(at_top, 0, code_above(c.extent));
  const int above = max_of(above_before, code_of_extent(high_m - top_m));
  const int below = code_of_extent(top_m - max_of(low_m, limit_m));
  c.extent = extent_of_codes(max_of(code_below(c.extent), below), above);
}

/** Rays that pass below what overhangs do not tell that it left; rays that went on where it is
 * known to have been do. Where such rays go while it is hit, it is open, and they tell nothing. */
TALUS_HD void look_between(
    Cell& c, int ix, int iy, float top_m, float hit_m, float limit_m, const Config& k,
    const Reach& reach)
{
  const bool hit = hit_m > limit_m;
  const Glance g = glance_at(k, *reach.frame, ix, iy);
  if (hit) put_extent(c, top_m, hit_m, limit_m, g, k, reach);
  const float lowest_m = top_m - extent_of_code(code_below(c.extent));
  const float low_m = max_of(lowest_m + k.cleanup_margin_m, limit_m);
  const float high_m = top_m + extent_of_code(code_above(c.extent)) - k.cleanup_margin_m;
  if (low_m >= high_m || !went_between(low_m, high_m, g, k, reach)) return;
  if (hit)
    c.extent = kOpen;
  else
    c.misses = 0;
}

TALUS_HD int trace_of(const Cell& c) { return c.passed & kTraceFull; }
TALUS_HD void leave_trace(Cell& c) { c.passed += min_of(kTraceHit, kTraceFull - trace_of(c)); }
/** Of a frame in which rays passed. False where there is none. */
TALUS_HD bool fade_trace(Cell& c)
{
  const bool any = trace_of(c) != 0;
  if (any) c.passed -= kTraceOne;
  return any;
}

/** Counts the evidence of one frame; true when the cell must be cleared. */
TALUS_HD bool count_miss(Cell& c, bool hit, const Config& k)
{
  const int before = c.misses;
  const int credit = (c.passed & kHitBefore) != 0 ? kHeldCredit : kPorousCredit;
  c.passed = hit ? c.passed | kHitBefore : c.passed & ~kHitBefore;
  const int after = hit ? max_of(min_of(before, 0) - credit, -kMaxCredit)
                        : (before <= -kPorous ? before + 1 : max_of(before, 0) + 1);
  const bool clear = after >= k.cleanup_frames;
  c.misses = clear ? 0 : after;
  return clear;
}

/** Clears what no longer stands there. A cell that was only hit below the passing rays is no
 * exception: a box that left shows the floor in the very cells that it stood in. Returns whether
 * the cell is another now. */
TALUS_HD bool clear_seen_through(
    Cell& c, int ix, int iy, std::uint8_t& role, float top_hit_m, const SeenThrough& seen,
    const Config& k, const Reach& reach)
{
  const bool has_elevation = is_known(c.elevation_m);
  if (!seen.any() || (!has_elevation && c.state != kMeasured)) return false;
  const float top = has_elevation ? c.elevation_m : c.ground_m;
  const float limit = seen.highest_m + k.cleanup_margin_m;
  if (top <= limit) return false;
  if (c.state == kMeasured && role == kKeep && c.ground_m > limit) role = kObject;
  const bool hit = top_hit_m > limit;
  if (hit && top_hit_m <= top + k.cleanup_margin_m) leave_trace(c);  // what hangs above leaves none
  if (c.misses < 0 && c.extent != kOpen) look_between(c, ix, iy, top, top_hit_m, limit, k, reach);
  if (!count_miss(c, hit, k)) return true;

  c.elevation_m = c.elevation_var_m2 = kNan;
  c.extent = 0;
  if (role >= kObject || c.ground_m > limit)
  {
    c.ground_m = c.ground_var_m2 = kNan;
    c.state = kUnknown;
    role = kInfer;
  }
  else if (c.state == kMeasured)
  {
    c.elevation_m = c.ground_m;
    c.elevation_var_m2 = c.ground_var_m2;
  }
  return true;
}

/** Where the rays of this frame passed the cells, window order. */
struct PassingRays
{
  float* lowest_m;  //!< infinity: no ray
  float* highest_m;  //!< bounds unseen ground from above
  std::uint8_t* in_open;  //!< 1: nothing was hit between the sensor and the cell
};

/** What the rays say of cell (ix, iy); needs nothing but the rays. */
struct LookThrough
{
  using Item = Glance;
  using Result = SeenThrough;
  int cells;
  const Config* config;
  const FrameContext* frame;
  const std::int32_t* rays;
  PassingRays passing;

  TALUS_HD Glance item(int ix, int iy) const { return glance_at(*config, *frame, ix, iy); }
  TALUS_HD int steps(const Glance& g) const { return g.rays(); }
  TALUS_HD void step(SeenThrough& seen, const Glance& g, int which) const
  {
    look(seen, g, which, *config, *frame, rays);
  }
  TALUS_HD void put(int ix, int iy, const SeenThrough& seen) const
  {
    const int o = iy * cells + ix;
    passing.lowest_m[o] = seen.lowest_m;
    passing.highest_m[o] = seen.highest_m;
    const bool in_open = (seen.in_open != 0) & seen.any();
    passing.in_open[o] = static_cast<std::uint8_t>(select(in_open, 1, 0));
  }

  TALUS_HD void operator()(int ix, int iy) const
  {
    const Glance g = item(ix, iy);
    SeenThrough seen;
    for (int which = 0; which < steps(g); which++) step(seen, g, which);
    put(ix, iy, seen);
  }
};

/** Stage 6 on cell (ix, iy), stored at i. */
struct CleanUpCell
{
  int cells;
  const Config* config;
  CellStore store;
  PassingRays passing;
  Reach reach;
  const float* top_hit_m;
  std::uint8_t* role;

  /** False where nothing changes. */
  TALUS_HD bool concerns(int ix, int iy, int i) const
  {
    const int o = iy * cells + ix, state = store.state[i];
    const float elevation = store.elevation_m[i], ground = store.ground_m[i];
    const bool has_elevation = is_known(elevation), any = passing.lowest_m[o] < kInfinity;
    const float top = select(has_elevation, elevation, ground);
    const bool above = (top > passing.highest_m[o] + config->cleanup_margin_m) &
                       (has_elevation | (state == kMeasured));
    const bool traced = store.passed[i] >= kTraceOne;
    return any & (state != kUnknown) & (above | traced);
  }

  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    const int o = iy * cells + ix;
    const SeenThrough seen{passing.lowest_m[o], passing.highest_m[o]};
    Cell c = store.load(i);
    const bool faded = fade_trace(c);
    if (clear_seen_through(c, ix, iy, role[i], top_hit_m[i], seen, *config, reach) || faded)
      store.store(i, c);
  }
};

}  // namespace talus::kernels
