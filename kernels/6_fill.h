#pragma once
#include "kernels/cell.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/lines.h"
#include "kernels/math.h"
#include "kernels/rays.h"
#include "kernels/rule_constants.h"
#include "kernels/rule_switches.h"
#include "kernels/surface.h"

namespace talus::kernels
{
// Stage 6 (III-B.3): ground of cells that were not measured, from samples on both sides along the
// line to the sensor. Each executor finds samples in its own way: a device searches for each cell
// (libs/core/src/cuda/fill_search.h), a core sweeps along many lines at once
// (libs/core/src/cpu/lines.h). The formulas are the same.

/** The samples of one side and their estimate by eq. 8. */
struct SideEstimate
{
  int places = 0;  //!< to the nearest sample
  float distance_m = 0;
  float nearest_m = kNan;  //!< height of the nearest sample; NaN: no samples
  float height_m = kNan;  //!< mu*: without a prior the kernel-weighted mean of the samples ...
  float mean_distance_m = 0;  //!< ... and where that lies

  static constexpr auto fields()
  {
    return std::make_tuple(
        &SideEstimate::places, &SideEstimate::distance_m, &SideEstimate::nearest_m,
        &SideEstimate::height_m, &SideEstimate::mean_distance_m);
  }
  TALUS_HD bool any() const { return is_known(nearest_m); }
  /** Empty cells before the first sample: n1, n2 of eq. 9. */
  TALUS_HD int gap_cells() const { return places - 1; }
};

/** Sparse kernel of eq. 8, k(d) = (2 + cos(2 pi d)) (1 - d) / 3 + sin(2 pi d) / (2 pi) with d the
 * distance over the kernel's support: e^5 times an even polynomial in e = 1 - d, error below
 * 7e-4. */
TALUS_HD float kernel_weight(float distance_m, const Config& k)
{
  const float e = max_of(1.0f - distance_m * k.inverse_fill_kernel, 0.0f), s = e * e;
  const float low = 8.45884817f - 14.8994038f * s, high = 9.94912180f - 2.50856619f * s;
  return s * s * e * (low + s * s * high);
}

/** The distance given to samples that do not count: beyond any kernel. */
constexpr float kOutOfReach_m = 1e18f;

/** Eq. 8: sparse kernel inference with the lowest sample as the prior. Samples come nearest first.
 */
struct SideSum
{
  float weights = 0, weighted = 0, lowest = kInfinity, lengths = 0;

  /** A sample at kOutOfReach_m changes nothing. */
  TALUS_HD void add(float height, float distance, const Config& k)
  {
    const float weight = kernel_weight(distance, k);
    weights += weight;
    weighted += weight * height;
    lengths += weight * distance;
    lowest = min_of(lowest, select(distance < kOutOfReach_m, height, kInfinity));
  }

  /** `nearest` and `places` belong to the first sample. Without a prior (lines) it is the mean. */
  template <bool kPrior>
  TALUS_HD SideEstimate estimate(float nearest, int places, float step_m, const Config& k) const
  {
    SideEstimate side;
    side.places = places;
    side.distance_m = static_cast<float>(places) * step_m;
    side.nearest_m = nearest;
    float all = weights, sum = weighted;
    if constexpr (kPrior) all += k.fill_lambda, sum += k.fill_lambda * lowest;
    const bool weighs = all > 0.0f;
    const float share = 1.0f / all;
    side.height_m = select(weighs, sum * share, nearest);
    side.mean_distance_m = select(weighs, lengths * share, side.distance_m);
    return side;
  }
};

/** The number of places of a line in a distance. */
TALUS_HD int places_in(float distance_m, float step_m, int rings)
{
  return floor_to_int(min_of(distance_m / step_m, static_cast<float>(rings)));
}

/** Bits of Samples::marks. */
enum SampleMark : std::int32_t
{
  kWall = 2,  //!< it rises more steeply than a robot drives, and holds nothing upright
  kContradicted = 4  //!< a ray seems to have passed below it, see kContradicted_m
};
/** Bits of Inference::marks. */
enum FillMark : std::int32_t
{
  kTwoSided = 2,
  kDoubtful = 4,  //!< one of its samples is contradicted
  kSlopes = 8,  //!< the ground falls in it by a step, as a slope does
  kDrops = 16  //!< the ground may drop in it
};
/** The variance of doubtful fills, and of fills in which the ground falls. */
constexpr float kDoubtful_m2 = 1.0f;

/** Whether a rise is steeper than a robot can drive, noise aside. */
TALUS_HD bool is_steep(float rise_m, float length_m, const Config& k)
{
  return rise_m > k.max_slope * length_m + kWallNoise_m;
}
TALUS_HD std::int32_t sample_marks(float ground_m, float top_m, float ray_bound_m, const Config& k)
{
  const float rise_m = top_m - ground_m;  // NaN without an object
  const bool wall =
      is_steep(rise_m, k.resolution_m, k) & (rise_m < kUpright_steps * k.step_threshold_m);
  const bool contradicted =
      on(kContradictedSamples, k) & (ray_bound_m < ground_m - kContradicted_m);
  return select(wall, kWall, 0) | select(contradicted, kContradicted, 0);
}

/** Whether rays pass below the ground that would go on level from a sample `away_m` away. */
TALUS_HD bool undercuts(float ray_bound_m, float sample_m, float away_m, const Config& k)
{
  return on(kUndercutDrops, k) & (ray_bound_m < sample_m - kUndercutAhead_m - kGentle * away_m);
}

/** Variance of ground inferred from a sample [m^2]. */
TALUS_HD float spread_variance(float sample_variance_m2, float distance_m, const Config& k)
{
  const float spread = k.fill_variance_per_m * distance_m;
  return sample_variance_m2 + spread * spread;
}

/** Eq. 9 as printed: one height from two sides. The share of the high side grows with its gap, up
 * to a half. */
TALUS_HD float combine_sides(const SideEstimate& a, const SideEstimate& b)
{
  const bool a_lower = a.height_m <= b.height_m;
  const SideEstimate& low = a_lower ? a : b;
  const SideEstimate& high = a_lower ? b : a;
  const float n_low = static_cast<float>(low.gap_cells());
  const float n_high = static_cast<float>(high.gap_cells());
  const float total = n_low + 2.0f * n_high;
  if (total == 0.0f) return 0.5f * (low.height_m + high.height_m);  // the gap is one cell
  return ((n_high + n_low) * low.height_m + n_high * high.height_m) / total;
}

/** The height of ground beyond samples that lie on one side. It goes on twice as far off the mean
 * as the nearest sample is, since it begins to rise or fall. A limit of a quarter of a step keeps
 * the foot of an object from counting more. */
TALUS_HD float goes_on(float nearest_m, float mean_m, const Config& k)
{
  const float off_m = on(kGroundGoesOn, k) ? nearest_m - mean_m : 0.0f;
  const float noise_m = max_of(min_of(off_m, kHeightNoise_m), -kHeightNoise_m);
  const float most_m = kGoesOnMost_steps * k.step_threshold_m;
  return mean_m + max_of(min_of(kGoesOn * (off_m - noise_m), most_m), -most_m);
}

/** Heights of several lines, weighted by the gaps that they bridge. */
struct LineFusion
{
  float information = 0, weighted = 0, lowest_m = kInfinity;

  static constexpr auto fields()
  {
    return std::make_tuple(&LineFusion::information, &LineFusion::weighted, &LineFusion::lowest_m);
  }
  /** Adds one line: linear between samples of both sides, goes_on() beside one side. The error
   * grows with the distances and with the height difference, since the ground may rise anywhere in
   * the gap. A gap holds a face if its sides differ by more than a robot can drive. Then along a
   * ray the lower side counts, which is the ground before a front and in the shadow of an edge.
   * Rows and columns do not show where the face is, and do not count. */
  TALUS_HD void add(const SideEstimate& a, const SideEstimate& b, bool along_ray, const Config& k)
  {
    const bool has_a = a.any(), has_b = b.any(), both = has_a & has_b;
    const float gap_m = a.distance_m + b.distance_m, rise = b.nearest_m - a.nearest_m;
    const bool face =
        on(kFaceInGap, k) & both & (gap_m > kFaceGap_m) & (abs_of(rise) > k.max_slope * gap_m);
    const float part = a.mean_distance_m / (a.mean_distance_m + b.mean_distance_m);
    const float linear = a.height_m + (b.height_m - a.height_m) * part;
    const float between = select(face, min_of(a.nearest_m, b.nearest_m), linear);
    const float of_rise = on(kRiseCounts, k) ? kRiseDeviation * abs_of(rise) : 0.0f;
    const float error = kBetweenDeviation * a.distance_m * b.distance_m / gap_m + of_rise;
    const float beyond =
        goes_on(select(has_a, a.nearest_m, b.nearest_m), select(has_a, a.height_m, b.height_m), k);
    const float height = select(both, between, beyond);
    const float deviation =
        select(both, error, kBeyondDeviation * select(has_a, a.distance_m, b.distance_m));
    const bool counts = along_ray | (!face & on(kRowsAndColumns, k));
    add(height, deviation, (has_a | has_b) & counts);
  }

  TALUS_HD void add(const LineFusion& other)
  {
    information += other.information;
    weighted += other.weighted;
    lowest_m = min_of(lowest_m, other.lowest_m);
  }

 private:
  TALUS_HD void add(float height_m, float deviation_m, bool known)
  {
    const float d = kLineDeviation_m + deviation_m, weight = 1.0f / (d * d);
    information += select(known, weight, 0.0f);
    weighted += select(known, height_m * weight, 0.0f);
    lowest_m = min_of(lowest_m, select(known, height_m, kInfinity));
  }
};

/** The estimate of a cell's ground from its lines. */
struct alignas(16) Inference
{
  LineFusion lines;  //!< for kFillPrinted: the result of eq. 9, as one line
  float variance_m2 = kNan;  //!< NaN: no samples

  TALUS_HD bool any() const { return is_known(variance_m2); }
};

/** Variance of one side of the line to the sensor; NaN: no samples. */
struct SideVariance
{
  float m2;
  std::int32_t marks;  //!< marks of its nearest sample
};

TALUS_HD float fuse_variances(const SideVariance& inner, const SideVariance& outer)
{
  const bool has_inner = is_known(inner.m2), both = has_inner & is_known(outer.m2);
  const float fused = inner.m2 * outer.m2 / (inner.m2 + outer.m2);
  return select(both, fused, select(has_inner, inner.m2, outer.m2));
}
/** Combines the marks of both sides to bits of FillMark. */
TALUS_HD std::int32_t fuse_marks(const SideVariance& inner, const SideVariance& outer)
{
  const bool has_inner = is_known(inner.m2), has_outer = is_known(outer.m2);
  const std::int32_t of_samples =
      select(has_inner, inner.marks, 0) | select(has_outer, outer.marks, 0);
  return select(has_inner & has_outer, kTwoSided, 0) |
         select((of_samples & kContradicted) != 0, kDoubtful, 0);
}

TALUS_HD LineFusion
fuse_lines(const SideEstimate& a, const SideEstimate& b, bool along_ray, const Config& k)
{
  LineFusion lines;
  lines.add(a, b, along_ray, k);
  return lines;
}

/** The result of eq. 9, as one line. */
TALUS_HD LineFusion apply_printed_rule(const SideEstimate& inner, const SideEstimate& outer)
{
  const bool both = inner.any() && outer.any();
  const float one = inner.any() ? inner.height_m : outer.height_m;
  LineFusion lines;
  lines.information = 1.0f;
  lines.weighted = both ? combine_sides(inner, outer) : one;
  lines.lowest_m = both ? min_of(inner.height_m, outer.height_m) : one;
  return lines;
}

struct Fill
{
  float height_m;
  float variance_m2;
  std::int32_t state;
};

TALUS_HD float height_of_lines(const LineFusion& lines, bool under_object)
{
  return select(under_object, lines.lowest_m, lines.weighted / lines.information);
}

TALUS_HD Fill
infer_ground(float variance_m2, int marks, float expected_m, float bound_m, const Config& k)
{
  const bool far_off = (marks & (kDoubtful | kSlopes | kDrops)) != 0;
  const int state = select((marks & kTwoSided) != 0, kFilledTwoSided, kFilledOneSided);
  return {
      min_of(expected_m, select(k.fill_use_ray_bound != 0, bound_m, kInfinity)),
      select(far_off, kDoubtful_m2, variance_m2), state};
}

/** Measured ground that fills may use, by place of the grid. */
struct Samples
{
  float* height_m;  //!< NaN: none
  float* variance_m2;
  std::int32_t* marks;  //!< bits of SampleMark
  float* ray_bound_m;  //!< for all places, see ray_bound(); used where lines are swept
};

/** The height that the ground of a cell cannot exceed, since rays passed there [m]; infinity: no
 * ray. Of the lowest rays of its directions the highest counts, so that a few reflections change
 * nothing. */
TALUS_HD float ray_bound(const PassingRays& passing, int window_i)
{
  return select(passing.lowest_m[window_i] < kInfinity, passing.highest_m[window_i], kInfinity);
}

TALUS_HD bool is_sample(const CellStore& store, const std::uint8_t* surface_class, int storage_i)
{
  return (store.state[storage_i] == kMeasured) & (surface_class[storage_i] == kKeep);
}

/** Drops an object that hangs so high that the robot fits below it, once rays passed there. Such
 * cells are few, so they have a rule of their own beside FillCell. */
struct DropHanging
{
  CellStore store;

  static TALUS_HD bool hangs(int flags)
  {
    const int both = kPassedLow | kHitHighUp;
    return (flags & both) == both;
  }
  TALUS_HD bool applies(int, int, int storage_i) const { return hangs(store.flags[storage_i]); }
  TALUS_HD void operator()(int, int, int storage_i) const
  {
    Cell c = store.load(storage_i);
    c.elevation_m = c.elevation_var_m2 = kNan;
    forget_persistence(c);
    forget_overhang(c);
    c.flags &= ~kHitHighUp;
    store.store(storage_i, c);
  }
};

/** Stage 6 on cell (ix, iy), stored at storage_i. Returns its state. A second call changes nothing.
 */
struct FillCell
{
  int cells;
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const std::uint8_t* surface_class;
  PassingRays passing;
  Surfaces surfaces;
  SurfaceLayers out;

  TALUS_HD bool wanted(int storage_i) const { return surface_class[storage_i] != kKeep; }

  TALUS_HD int operator()(int ix, int iy, int storage_i, const Inference& inferred, int marks) const
  {
    const int window_i = iy * cells + ix;
    const int r = surface_class[storage_i], state_before = store.state[storage_i];
    const int flags_before = store.flags[storage_i], in_open = passing.in_open[window_i];
    const int driven_height = store.driven_height[storage_i];
    const float before = store.ground_m[storage_i], var_before = store.ground_var_m2[storage_i];
    // Otherwise the older fill, or the object, stays.
    const bool filled = (r != kKeep) & inferred.any();
    const bool doubtful = filled & ((marks & kDoubtful) != 0);
    const float bound_m = select(doubtful, kInfinity, ray_bound(passing, window_i));
    const float expected_m =
        height_of_lines(inferred.lines, (r == kObject) & on(kLowestUnderObject, *config));
    const Fill fill = infer_ground(inferred.variance_m2, marks, expected_m, bound_m, *config);
    const float ground = select(filled, fill.height_m, before);
    const float variance = select(filled, fill.variance_m2, var_before);
    const int state = select(filled, fill.state, state_before);
    // Behind a hit only rays below the height of a step prove that the ground is free. In the blind
    // zone around the robot, before all hits, rays below the clearance do.
    const float proof_m = select(in_open != 0, config->clearance_m, config->step_threshold_m);
    // A fill may lie too high, so it counts at most a little above the lowest of its lines.
    const float low_m = inferred.lines.lowest_m + kAboveLowestLine_steps * config->step_threshold_m;
    const float floor_m = min_of(ground, select(filled, low_m, kInfinity));
    const bool low = bound_m < floor_m + proof_m;
    const bool near = bound_m < floor_m + kPassedNear_steps * config->step_threshold_m;
    const bool object = filled & (r == kObject) & (before - fill.height_m > config->clearance_m);
    const float stands_m = store.elevation_m[storage_i];
    const int fall = select(filled & !doubtful, marks & (kSlopes | kDrops), 0);
    const bool drops = on(kFallsMayDrop, *config) & ((fall & kDrops) != 0) & !is_known(stands_m);
    const int flags = (flags_before & select((fall == kSlopes) | (r == kKeep), ~kMayDrop, ~0)) |
                      select(low, kPassedLow, 0) | select(object, kHitHighUp, 0) |
                      select(near & on(kPassedNearJudged, *config), kPassedNear, 0) |
                      select(drops, kMayDrop, 0);
    // Reads come before stores, or the compiler would read again and not vectorise.
    store.ground_m[storage_i] = ground;
    store.ground_var_m2[storage_i] = variance;
    store.state[storage_i] = static_cast<std::uint8_t>(state);
    store.flags[storage_i] = static_cast<std::uint8_t>(flags);
    const float elevation = select(DropHanging::hangs(flags), kNan, stands_m);
    put_surface(
        surfaces.cell[surfaces.at(ix, iy)], {ground, elevation, state, flags, driven_height});
    return state;
  }

 private:
  /** The fields that stage 7 reads. */
  struct Filled
  {
    float ground_m, elevation_m;
    int state, flags, driven_height;
  };
  TALUS_HD void put_surface(Surface& to, const Filled& c) const
  {
    const float ground = c.ground_m;
    const bool stands = is_known(c.elevation_m), measured = c.state == kMeasured;
    const bool near = (c.state == kFilledTwoSided) & ((c.flags & kPassedNear) != 0);
    const bool met = measured | stands | (c.state == kPresumed), known = is_known(ground);
    const bool new_there = stands & (c.elevation_m - ground > driven_height_m(c.driven_height));
    const bool driven = (c.driven_height > 0) & !new_there;
    const bool proven = ((c.flags & kPassedLow) != 0) | !on(kProofOfFills, *config);
    const bool seen = met | (proven & known);
    const bool may_drop = ((c.flags & kMayDrop) != 0) & !(stands | driven);
    const std::int32_t flags = select(measured, kSurfaceMeasured, 0) |
                               select(seen, kSurfaceSeen, 0) |
                               select(may_drop, kSurfaceMayDrop, 0) |
                               select(driven, kSurfaceDriven, 0) | select(near, kSurfaceNear, 0);
    const float reference = frame->sensor_z_m, top = select(stands, c.elevation_m, ground);
    to.ground = select(known, quantise_height(select(known, ground, 0.0f), reference), kNoHeight);
    to.height_and_flags = select(
        known, (1 << kSurfaceFlags) * quantise_height(select(known, top, 0.0f), reference) + flags,
        0);
  }
};

}  // namespace talus::kernels
