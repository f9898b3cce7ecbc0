#pragma once
#include "kernels/rays.h"

namespace talus::kernels
{
// Stage 6 (III-B.2): cells that this frame did not touch, but whose surface stands above a ray that
// went on behind it, are cleared down to their ground. One sweep from the outermost ring inwards
// turns the hits of each ring into the lowest ray that passed it; then each cell is a look-up. The
// same table bounds unseen ground from above.

/** One direction: replaces the lowest hit of each ring by the lowest ray that went at least that
 * far. */
struct SweepRays
{
  const Config* config;
  std::int32_t* rays;

  TALUS_HD void operator()(int bin, int = 0) const
  {
    const int bins = bin_count(*config);
    std::int32_t lowest = kNoRay;
    for (int ring = ring_count(*config) - 1; ring >= 0; ring -= kBatch)
    {
      // Loads first, so that they do not wait for each other.
      std::int32_t hits[kBatch];
      for (int b = 0; b < kBatch; b++)
        hits[b] = ring - b < 0 ? kNoRay : rays[(ring - b) * bins + bin];
      for (int b = 0; b < kBatch && ring - b >= 0; b++)
      {
        lowest = hits[b] < lowest ? hits[b] : lowest;
        rays[(ring - b) * bins + bin] = lowest;
      }
    }
  }

 private:
  static constexpr int kBatch = 32;
};

/** What the rays of this frame say of one cell. */
struct SeenThrough
{
  float lowest_m =
      kInfinity;  //!< lowest height at which a ray passed; bounds unseen ground from above
  float highest_m = -kInfinity;  //!< the highest among the lowest rays of the cell's directions
  bool in_open = true;  //!< nothing was hit between the sensor and the cell
  TALUS_HD bool any() const { return lowest_m < kInfinity; }
};

constexpr int kMaxBinsPerCell = 8;

/** Rays through the middle half of the angle under which the sensor sees a cell, that ended two or
 * more rings behind it. Heights are taken where the ray is highest inside the cell. */
TALUS_HD SeenThrough
look_through(const Config& k, const FrameContext& f, const std::int32_t* rays, int ix, int iy)
{
  SeenThrough seen;
  const float dx = (static_cast<float>(ix) + 0.5f) * k.resolution_m - f.sensor_x_m;
  const float dy = (static_cast<float>(iy) + 0.5f) * k.resolution_m - f.sensor_y_m;
  const float chebyshev_m = max_of(abs_of(dx), abs_of(dy));
  const float ring = chebyshev_m * k.inverse_resolution;
  if (ring < 2.0f) return seen;  // under the sensor
  const int row = min_of(floor_to_int(ring) + 2, ring_count(k) - 1);

  const int bins = bin_count(k), per_side = bins_per_side(k);
  const float half_span = 0.125f * static_cast<float>(per_side) / ring;
  const float middle = direction_in_bins(dx, dy, per_side);
  const int first = floor_to_int(middle - half_span), last = floor_to_int(middle + half_span);
  const int stride = (last - first) / kMaxBinsPerCell + 1;
  const float half_cell = 0.5f * k.resolution_m;
  for (int b = first; b <= last; b += stride)
  {
    const std::int32_t hit = rays[row * bins + wrap_bin(b, bins)];
    seen.in_open = seen.in_open && hit == rays[wrap_bin(b, bins)];
    if (hit == kNoRay) continue;
    const float slope = float_from_ordered(hit);
    const float where = slope < 0.0f ? chebyshev_m - half_cell : chebyshev_m + half_cell;
    const float height = f.sensor_z_m + slope * where;
    seen.lowest_m = min_of(seen.lowest_m, height);
    seen.highest_m = max_of(seen.highest_m, height);
  }
  return seen;
}

/** Counts the evidence of one frame; true when the cell must be cleared. */
TALUS_HD bool count_miss(Cell& c, bool hit, const Config& k)
{
  const int before = c.misses;
  const int after = hit ? max_of(min_of(before, 0) - kPorousCredit, -kMaxCredit)
                        : (before <= -kPorous ? before + 1 : max_of(before, 0) + 1);
  const bool clear = after >= k.cleanup_frames;
  c.misses = static_cast<std::int8_t>(clear ? 0 : after);
  return clear;
}

/** Clears what no longer stands there. A cell that was only hit below the passing rays is no
 * exception: a box that left shows the floor in the very cells that it stood in. Returns whether
 * the cell is another now. */
TALUS_HD bool clear_seen_through(
    Cell& c, std::uint8_t& role, float top_hit_m, const SeenThrough& seen, const Config& k)
{
  const bool has_elevation = is_known(c.elevation_m);
  if (!seen.any() || (!has_elevation && c.state != kMeasured)) return false;
  const float top = has_elevation ? c.elevation_m : c.ground_m;
  const float limit = seen.highest_m + k.cleanup_margin_m;
  if (top <= limit) return false;
  if (c.state == kMeasured && role == kKeep && c.ground_m > limit) role = kObject;
  if (!count_miss(c, top_hit_m > limit, k)) return true;

  c.elevation_m = c.elevation_var_m2 = kNan;
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
  float* lowest_m;  //!< bounds unseen ground from above; infinity: no ray
  float* highest_m;
};

/** What the rays say of cell (ix, iy); needs nothing but the rays. */
struct LookThrough
{
  const Config* config;
  const FrameContext* frame;
  const std::int32_t* rays;
  CellStore store;
  PassingRays passing;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const SeenThrough seen = look_through(*config, *frame, rays, ix, iy);
    passing.lowest_m[iy * config->cells + ix] = seen.lowest_m;
    passing.highest_m[iy * config->cells + ix] = seen.highest_m;
    std::uint8_t& passed = store.passed[storage_index(*frame, config->cells, ix, iy)];
    passed = static_cast<std::uint8_t>(
        (passed & kPassedLow) | (seen.in_open && seen.any() ? kInOpen : 0));
  }
};

/** Stage 6 on cell (ix, iy). */
struct CleanUpCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  PassingRays passing;
  const float* top_hit_m;
  std::uint8_t* role;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int n = config->cells;
    const int i = storage_index(*frame, n, ix, iy);
    const SeenThrough seen{passing.lowest_m[iy * n + ix], passing.highest_m[iy * n + ix]};
    if (!seen.any() || store.state[i] == kUnknown) return;
    Cell c = store.load(i);
    if (clear_seen_through(c, role[i], top_hit_m[i], seen, *config)) store.store(i, c);
    // A fill that a ray now contradicts is inferred again.
    if (config->fill_use_ray_bound && c.state == kFilledTwoSided &&
        c.ground_m > seen.lowest_m + config->cleanup_margin_m)
      role[i] = kInfer;
  }
};

}  // namespace talus::kernels
