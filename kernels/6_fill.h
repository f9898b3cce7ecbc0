#pragma once
#include "kernels/map.h"

namespace talus::kernels
{
// Stage 6 (III-B.3): ground that was not measured, from samples on both sides along the line to the
// sensor. A device searches for them cell by cell (libs/core/src/cuda/fill_search.h), a core sweeps
// along many lines at once (libs/core/src/cpu/lines.h). The formulas are the same.

/** The samples of one side, and their mean by the sparse kernel of eq. 8. */
struct SideEstimate
{
  int cells = 0;  //!< to the nearest sample; 0: farther than fills search
  float distance_m = 0;
  float nearest_m = kNan;  //!< height of the nearest sample; NaN: no samples
  float height_m = kNan;  //!< the mean of the samples ...
  float mean_distance_m = 0;  //!< ... and where that lies
  TALUS_HD bool any() const { return is_known(nearest_m); }
  TALUS_HD bool near() const { return cells > 0; }
};

/** Sparse kernel of eq. 8, k(d) = (2 + cos(2 pi d)) (1 - d) / 3 + sin(2 pi d) / (2 pi), d the
 * distance over its support: e^5 times an even polynomial in e = 1 - d, error below 7e-4. */
TALUS_HD float kernel_weight(float distance_m, const Config& k)
{
  const float e = max_of(1.0f - distance_m * k.inverse_fill_kernel, 0.0f), s = e * e;
  const float low = 8.45884817f - 14.8994038f * s, high = 9.94912180f - 2.50856619f * s;
  return s * s * e * (low + s * s * high);
}

/** The distance given to samples that do not count: beyond any kernel. */
constexpr float kOutOfReach_m = 1e18f;

/** Eq. 8 without its prior, the lowest sample, which pulls slopes down. The nearest come first. */
struct SideSum
{
  float weights = 0, weighted = 0, lengths = 0;

  /** A sample at kOutOfReach_m changes nothing. */
  TALUS_HD void add(float height, float distance, const Config& k)
  {
    const float weight = kernel_weight(distance, k);
    weights += weight;
    weighted += weight * height;
    lengths += weight * distance;
  }

  /** All values belong to the first sample. */
  TALUS_HD SideEstimate estimate(float nearest, int cells, float distance_m) const
  {
    SideEstimate side;
    side.cells = cells;
    side.distance_m = distance_m;
    side.nearest_m = nearest;
    const bool weighs = weights > 0.0f;
    const float share = 1.0f / weights;
    side.height_m = select(weighs, weighted * share, nearest);
    side.mean_distance_m = select(weighs, lengths * share, side.distance_m);
    return side;
  }
};

TALUS_HD int cells_in(float distance_m, float cell_m, int rings)
{
  return floor_to_int(min_of(distance_m / cell_m, static_cast<float>(rings)));
}

/** What the line from the sensor says of a cell, as bits. */
enum FillMark : std::int32_t
{
  kInferred = 1023,  //!< cells to the sample of one side; none: nothing else counts
  kTwoSided = 1024,
  kSlopes = 2048,  //!< the ground falls in it by a step, as a slope does
  kDrops = 4096,  //!< the ground may drop in it
  kBridged = 8192  //!< it has samples on both sides, near or far
};
/** The variance of fills in which the ground falls; the max length of a line in a cell. */
constexpr float kFalls_m2 = 1.0f, kDiagonal_cells = 1.4143f;

/** Whether a rise is steeper than a robot can drive, noise aside. */
TALUS_HD bool is_steep(float rise_m, float length_m, const Config& k)
{
  return rise_m > k.max_slope * length_m + kWallNoise_m;
}
/** Bits of the height of a sample: it is a face, whose ground rises within the cell, or the robot
 * stood there: a height, but no edge. Compilers do not vectorise a test of the last bit. */
constexpr std::uint32_t kFaceBit = 2, kStoodBit = 4;
TALUS_HD bool is_stood(float sample_m) { return (bits_of(sample_m) & kStoodBit) != 0; }
TALUS_HD bool is_face(float sample_m) { return (bits_of(sample_m) & kFaceBit) != 0; }
/** Whether rays over a cell ended below ground that falls gently from a sample: that is an edge. */
TALUS_HD bool ends_below_ground(float ends_m, float sample_m, float away_m)
{
  return !is_stood(sample_m) & (ends_m < sample_m - kEndsBelow_m - gentle_fall_m(away_m));
}

struct LineFusion
{
  float information = 0, weighted = 0, lowest_m = kInfinity;

  TALUS_HD void add(const LineFusion& other)
  {
    information += other.information;
    weighted += other.weighted;
    lowest_m = min_of(lowest_m, other.lowest_m);
  }
};

/** One line with samples near by: linear between samples of both sides, the other of which may be
 * far; their mean beside one side. The error grows with the distances, as ground is curved, and
 * with the height difference, since the ground may rise anywhere in the gap. */
TALUS_HD LineFusion fuse_sides(const SideEstimate& a, const SideEstimate& b)
{
  const bool has_a = a.any(), has_b = b.any(), both = has_a & has_b, any = a.near() | b.near();
  const float part = a.mean_distance_m / (a.mean_distance_m + b.mean_distance_m);
  const float between_m = a.height_m + (b.height_m - a.height_m) * part;
  const float error_m = kBetweenDeviation * a.distance_m * b.distance_m +
                        kRiseDeviation * abs_of(b.nearest_m - a.nearest_m);
  const float beyond_m = kBeyondDeviation * select(has_a, a.distance_m, b.distance_m);
  const float height_m = select(both, between_m, select(has_a, a.height_m, b.height_m));
  const float d = kLineDeviation_m + select(both, error_m, beyond_m), weight = 1.0f / (d * d);
  LineFusion line;
  line.add(
      {select(any, weight, 0.0f), select(any, height_m * weight, 0.0f),
       select(any, height_m, kInfinity)});
  return line;
}

/** The variance of a fill, by the gaps of its lines and the rises in them, from one side by its own
 * gap at least; half of what the mean lies above the lowest says how rough ground is there. */
TALUS_HD float variance_of_fill(const LineFusion& lines, int marks, const Config& k)
{
  const float apart_m = kLinesApart * (lines.weighted / lines.information - lines.lowest_m);
  const float line_m = sqrtf(kFillLines / lines.information) - kLineDeviation_m;
  const int cells = select((marks & kTwoSided) != 0, 0, marks & kInferred);
  const float away_m = kDiagonal_cells * k.resolution_m * static_cast<float>(cells);
  const float gap_m =
      k.fill_variance_per_m / kBeyondDeviation * max_of(line_m, kBeyondDeviation * away_m);
  return max_of(apart_m * apart_m + gap_m * gap_m, k.min_variance_m2);
}

/** Bits of FillMark of a cell between the inner and the outer side. */
TALUS_HD std::int32_t marks_of_sides(
    const SideEstimate& inner, const SideEstimate& outer, bool drop_ahead)
{
  const bool in = inner.near(), out = outer.near();
  return inner.cells | outer.cells | select(in & out, kTwoSided, 0) |
         select(inner.any() & outer.any(), kBridged, 0) | select(in & !out & drop_ahead, kDrops, 0);
}

/** The lowest of some lines, and a little more: a fill may lie too high. */
TALUS_HD float low_line_m(const LineFusion& lines, const Config& k)
{
  return lines.lowest_m + kAboveLowestLine_steps * k.step_threshold_m;
}
/** The ground below an object is its foot, which lies as low as the lower side. */
TALUS_HD float fill_of_lines(const LineFusion& lines, float low_m, bool under_object)
{
  const float mean_m = lines.weighted / lines.information;
  return select(under_object, min_of(mean_m, low_m), mean_m);
}

/** How high above its ground a cell is free at least where it is judged. Rays as low as a step
 * prove that nothing stands there. Above ground between known ground, and in the blind zone around
 * the robot, before all hits, higher rays do. */
TALUS_HD float proof_m(int state, bool unobstructed, const Config& k)
{
  const float between_steps = select(state == kFilledTwoSided, kFreeBetween_steps, 1.0f);
  return select(unobstructed, k.clearance_m, between_steps * k.step_threshold_m);
}

/** Keeps the sample of a cell for fills; NaN: none. Returns whether there is one. */
struct TakeSample
{
  const Map& m;

  TALUS_HD bool operator()(int ix, int iy, int i) const
  {
    const float sample_m = sample(i);
    m.sample_m[m.lines.at(ix, iy)] = sample_m;
    return is_known(sample_m);
  }

 private:
  TALUS_HD float sample(int i) const
  {
    const float ground_m = m.cell.ground_m[i], top_m = m.cell.elevation_m[i];
    const int state = m.cell.state[i];
    const bool stood = (state == kPresumed) & (m.k.start_radius_m > 0.0f) &
                       ((m.cell.flags[i] & kRobotWasThere) != 0);
    const bool is_one = ((state == kMeasured) & (m.surface_class[i] == kKeep)) | stood;
    const bool rises = (top_m > bare_up_to_m(ground_m, m.k)) &
                       (top_m <= ground_m + kUpright_steps * m.k.step_threshold_m);
    const std::uint32_t bits = select(rises, static_cast<int>(kFaceBit), 0) |
                               select(stood, static_cast<int>(kStoodBit), 0);
    return select(
        is_one, float_of_bits((bits_of(ground_m) & ~(kFaceBit | kStoodBit)) | bits), kNan);
  }
};

/** Stage 6 on a cell. Returns its state. A second call changes nothing. */
struct FillCell
{
  const Map& m;

  TALUS_HD bool wanted(int i) const { return m.surface_class[i] != kKeep; }

  TALUS_HD int operator()(int ix, int iy, int i, const LineFusion& lines, int marks) const
  {
    const Config& k = m.k;
    const int at = m.lines.at(ix, iy);
    const int r = m.surface_class[i], state_before = m.cell.state[i];
    const int flags_before = m.cell.flags[i];
    const bool unobstructed = m.unobstructed[at] != 0;
    const float beside_m = m.pair_beside_m[m.pair_of(ix, iy)];
    const int driven_height = m.cell.driven_height[i];
    const float before = m.cell.ground_m[i], var_before = m.cell.ground_var_m2[i];
    const float stands_m = m.cell.elevation_m[i], free_m = m.free_above_m[at];
    const float ends_m = m.ends_m[at];
    // Otherwise the older fill, or the object, stays.
    const bool filled = (r != kKeep) & ((marks & kInferred) != 0);
    const bool two_sided = (marks & kTwoSided) != 0;
    const float low_m = low_line_m(lines, k);
    const float fill_m = fill_of_lines(lines, low_m, (r == kObject) & on(kLowestUnderObject, k));
    const float ground = select(filled, fill_m, before);
    const int fall = select(filled, marks & (kSlopes | kDrops), 0);
    const float fill_m2 = select(fall != 0, kFalls_m2, variance_of_fill(lines, marks, k));
    const float variance = select(filled, fill_m2, var_before);
    const int filled_as = select(two_sided, kFilledTwoSided, kFilledOneSided);
    const int state = select(filled, filled_as, state_before);
    const float floor_m = min_of(ground, select(filled, low_m, kInfinity));
    const bool bridged = filled & ((marks & kBridged) != 0);
    const bool goes_on = (state != kFilledOneSided) | bridged | !(floor_m > ends_m + kEndsBelow_m);
    const bool hidden = beside_m < floor_m + k.clearance_m;
    const float proof = select(hidden, k.step_threshold_m, proof_m(state, unobstructed, k));
    const bool low = goes_on & (free_m < floor_m + proof);
    const bool object = filled & (r == kObject) & (before - fill_m > k.clearance_m);
    const bool drops = on(kDropOffs, k) & ((fall & kDrops) != 0) & !is_known(stands_m);
    const int flags =
        (flags_before & select((fall == kSlopes) | (r == kKeep), ~kPossibleDropOff, ~0) &
         select(goes_on, ~0, ~kPassedLow)) |
        select(low, kPassedLow, 0) | select(object, kHitHighUp, 0) |
        select(drops, kPossibleDropOff, 0);
    // Reads come before stores, or the compiler would read again and not vectorise.
    m.cell.ground_m[i] = ground;
    m.cell.ground_var_m2[i] = variance;
    m.cell.state[i] = static_cast<std::uint8_t>(state);
    m.cell.flags[i] = static_cast<std::uint8_t>(flags);
    put_surface(
        m.judged_surface[m.surface_at(ix, iy)], {ground, stands_m, state, flags, driven_height});
    return state;
  }

 private:
  struct Filled
  {
    float ground_m, elevation_m;
    int state, flags, driven_height;
  };
  TALUS_HD void put_surface(Surface& to, const Filled& c) const
  {
    const float ground = c.ground_m;
    const bool stands = is_known(c.elevation_m), known = is_known(ground);
    const bool met = (c.state == kMeasured) | stands | (c.state == kPresumed);
    const bool new_there = stands & (c.elevation_m - ground > driven_height_m(c.driven_height));
    const bool driven = was_driven_through(c.driven_height) & !new_there;
    const bool proven = ((c.flags & kPassedLow) != 0) | !on(kProofOfFills, m.k);
    const bool seen = met | (proven & known);
    const bool possible_drop_off = ((c.flags & kPossibleDropOff) != 0) & !(stands | driven);
    const std::int32_t flags = select(seen, kSurfaceSeen, 0) |
                               select(possible_drop_off, kSurfacePossibleDropOff, 0) |
                               select(driven, kSurfaceDriven, 0);
    const float reference = m.frame->sensor_z_m, top = select(stands, c.elevation_m, ground);
    to.ground = select(known, quantise_height(select(known, ground, 0.0f), reference), kNoHeight);
    to.height_and_flags = select(
        known, (1 << kSurfaceFlags) * quantise_height(select(known, top, 0.0f), reference) + flags,
        0);
  }
};

}  // namespace talus::kernels
