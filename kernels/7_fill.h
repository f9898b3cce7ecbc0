#pragma once
#include "kernels/rays.h"

namespace talus::kernels
{
// Stage 7 (III-B.3): ground of cells that were not measured, from samples found along the line to
// the sensor: towards it and away from it. Each line keeps one bit a ring, "measured ground here";
// finding the next sample is then a bit scan instead of a walk.

TALUS_HD int words_per_line(const Config& k) { return line_rings(k) / 32 + 1; }

/** One word of one line; bit r: the cell at ring 32 * word + r is measured ground. Layout
 * [word][line]. */
struct MarkLineWord
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const std::uint8_t* role;
  std::uint32_t* marks;

  TALUS_HD void operator()(int line, int word) const
  {
    const int rings = line_rings(*config), n = config->cells;
    const Line l = line_from_index(line, rings);
    std::uint32_t bits = 0;
    const int last = min_of(32 * word + 31, rings);
    for (int ring = 32 * word; ring <= last; ring++)
    {
      const CellOffset o = line_cell(l, ring, rings);
      const int ix = n / 2 + o.dx, iy = n / 2 + o.dy;
      if (ix >= n || iy >= n || ix < 0 || iy < 0) continue;
      const int i = storage_index(*frame, n, ix, iy);
      if (store.state[i] == kMeasured && role[i] == kKeep) bits |= 1u << (ring - 32 * word);
    }
    marks[word * line_count(*config) + line] = bits;
  }
};

TALUS_HD int lowest_bit(std::uint32_t bits)
{
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(bits)) - 1;
#else
  return __builtin_ctz(bits);
#endif
}

TALUS_HD int highest_bit(std::uint32_t bits)
{
#if defined(__CUDA_ARCH__)
  return 31 - __clz(static_cast<int>(bits));
#else
  return 31 - __builtin_clz(bits);
#endif
}

/** Walks the marked rings of one line. */
struct LineMarks
{
  const std::uint32_t* marks;  //!< of word 0 of this line
  int stride;  //!< between words
  int rings;

  /** The nearest marked ring below `ring`, or -1. */
  TALUS_HD int inwards(int ring, int limit) const
  {
    const int from = ring - 1;
    if (from < 0) return -1;
    int word = from >> 5;
    std::uint32_t bits = marks[word * stride] & (0xffffffffu >> (31 - (from & 31)));
    while (!bits && --word >= 0 && 32 * word + 31 >= limit) bits = marks[word * stride];
    if (!bits) return -1;
    const int found = 32 * word + highest_bit(bits);
    return found >= limit ? found : -1;
  }

  /** The nearest marked ring above `ring`, or -1. */
  TALUS_HD int outwards(int ring, int limit) const
  {
    const int from = ring + 1;
    if (from > rings) return -1;
    int word = from >> 5;
    const int last_word = rings >> 5;
    std::uint32_t bits = marks[word * stride] & (0xffffffffu << (from & 31));
    while (!bits && ++word <= last_word && 32 * word <= limit) bits = marks[word * stride];
    if (!bits) return -1;
    const int found = 32 * word + lowest_bit(bits);
    return found <= limit ? found : -1;
  }
};

/** The samples of one side and what eq. 8 makes of them. */
struct SideEstimate
{
  int gap_cells = 0;  //!< empty cells before the first sample: n1, n2 of eq. 9
  float height_m = kNan;  //!< mu*; NaN: no samples
  float variance_m2 = 0;
  float distance_m = 0;  //!< to the nearest sample
  float nearest_m = kNan;  //!< height of the nearest sample
};

/** Everything that the line search of one cell needs. */
struct LineSearch
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  Line line;
  LineMarks marks;
  int ring;
  float ring_length_m;  //!< length of the line per ring

  TALUS_HD int storage_at(int at_ring) const
  {
    const int n = config->cells;
    const CellOffset o = line_cell(line, at_ring, line_rings(*config));
    return storage_index(*frame, n, n / 2 + o.dx, n / 2 + o.dy);
  }

  /** How many rings a distance is. */
  TALUS_HD int rings_in(float distance_m) const
  {
    return floor_to_int(min_of(distance_m / ring_length_m, static_cast<float>(marks.rings)));
  }

  TALUS_HD int next(int from, bool outwards, float reach_m) const
  {
    return outwards ? marks.outwards(from, ring + rings_in(reach_m))
                    : marks.inwards(from, max_of(ring - rings_in(reach_m), 0));
  }

  /** Eq. 8: sparse kernel inference with the lowest sample as the prior. */
  TALUS_HD SideEstimate infer_side(bool outwards) const
  {
    SideEstimate side;
    float weights = 0, weighted = 0, lowest = kInfinity;
    int at = ring;
    for (int s = 0; s < config->fill_samples; s++)
    {
      at = next(at, outwards, config->fill_search_m);
      if (at < 0) break;
      const int i = storage_at(at);
      const float height = store.ground_m[i];
      const float distance = static_cast<float>(abs_of(at - ring)) * ring_length_m;
      if (s == 0)
      {
        side.gap_cells = abs_of(at - ring) - 1;
        side.distance_m = distance;
        side.nearest_m = height;
        const float spread = config->fill_variance_per_m * distance;
        side.variance_m2 = store.ground_var_m2[i] + spread * spread;
      }
      const float w = kernel_weight(distance);
      weights += w;
      weighted += w * height;
      lowest = min_of(lowest, height);
    }
    if (lowest < kInfinity)
      side.height_m = (config->fill_lambda * lowest + weighted) / (config->fill_lambda + weights);
    return side;
  }

  TALUS_HD float kernel_weight(float distance_m) const
  {
    const int i = floor_to_int(
        distance_m * config->inverse_fill_kernel * static_cast<float>(kKernelTableSize));
    return i < kKernelTableSize ? config->fill_kernel[i] : 0.0f;
  }
};

TALUS_HD LineSearch line_search(
    const Config& k, const FrameContext& f, const CellStore& store, const std::uint32_t* marks,
    int dx, int dy)
{
  const int rings = line_rings(k);
  const int ring = max_of(abs_of(dx), abs_of(dy));
  const Line line = line_through(dx, dy, ring, rings);
  const LineMarks line_marks{marks + line_index(line, rings), line_count(k), rings};
  return {&k, &f, store, line, line_marks, ring, line_stretch(line, rings) * k.resolution_m};
}

/** Eq. 9 and its alternatives: one height from two sides. */
TALUS_HD float combine_sides(const SideEstimate& a, const SideEstimate& b, int rule)
{
  const bool a_lower = a.height_m <= b.height_m;
  const SideEstimate& low = a_lower ? a : b;
  const SideEstimate& high = a_lower ? b : a;
  if (rule == kFillMinimum) return low.height_m;
  if (rule == kFillInverseDistance)
  {
    const float t = low.distance_m / (low.distance_m + high.distance_m);
    return low.nearest_m + t * (high.nearest_m - low.nearest_m);
  }
  // The high side's share grows with the gap to the low side (exchanged) or to the high side
  // (printed), up to a half.
  const float n_share = static_cast<float>(rule == kFillPrinted ? high.gap_cells : low.gap_cells);
  const float n_other = static_cast<float>(rule == kFillPrinted ? low.gap_cells : high.gap_cells);
  const float total = n_other + 2.0f * n_share;
  if (total == 0.0f) return 0.5f * (low.height_m + high.height_m);  // a gap of one cell
  return ((n_share + n_other) * low.height_m + n_share * high.height_m) / total;
}

/** What was inferred for a cell; state kUnknown: nothing. */
struct Fill
{
  float height_m = kNan;
  float variance_m2 = kNan;
  std::uint8_t state = kUnknown;
};

TALUS_HD Fill
infer_ground(const LineSearch& search, bool under_object, float bound_m, const Config& k)
{
  const SideEstimate inner = search.infer_side(false), outer = search.infer_side(true);
  const bool has_inner = is_known(inner.height_m), has_outer = is_known(outer.height_m);
  if (!has_inner && !has_outer) return {};
  Fill fill;
  if (has_inner && has_outer)
  {
    fill.height_m = combine_sides(inner, outer, under_object ? kFillMinimum : k.fill_rule);
    fill.variance_m2 = 1.0f / (1.0f / inner.variance_m2 + 1.0f / outer.variance_m2);
    fill.state = kFilledTwoSided;
  }
  else
  {
    const SideEstimate& side = has_inner ? inner : outer;
    fill.height_m = side.height_m;
    fill.variance_m2 = side.variance_m2;
    fill.state = kFilledOneSided;
  }
  if (k.fill_use_ray_bound) fill.height_m = min_of(fill.height_m, bound_m);
  return fill;
}

/** Puts inferred ground under a cell. What stood there as an object hangs if the robot fits below
 * it. */
TALUS_HD void place_fill(Cell& c, const Fill& fill, std::uint8_t role, const Config& k)
{
  if (role == kObject && c.ground_m - fill.height_m > k.clearance_m)
    c.elevation_m = c.elevation_var_m2 = kNan;
  c.ground_m = fill.height_m;
  c.ground_var_m2 = fill.variance_m2;
  c.state = fill.state;
}

/** The surfaces of the frame in window order, quantised, for stage 8; columns padded by the feature
 * radius. */
struct Surfaces
{
  std::int32_t* ground;
  std::int32_t* height;  //!< elevation, or ground where nothing stands
  int pitch, pad;

  TALUS_HD int at(int ix, int iy) const { return iy * pitch + ix + pad; }
};

constexpr std::int32_t kNoHeight = -0x7fffffff - 1;

/** Stage 7 on cell (ix, iy). */
struct FillCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const std::uint8_t* role;
  const std::uint32_t* marks;
  const float* ray_bound_m;
  Surfaces surfaces;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int n = config->cells;
    const int i = storage_index(*frame, n, ix, iy);
    const int dx = ix - n / 2, dy = iy - n / 2;
    if (role[i] != kKeep && (dx != 0 || dy != 0)) infer(i, dx, dy, ray_bound_m[iy * n + ix]);

    const float ground = store.ground_m[i], elevation = store.elevation_m[i];
    const int s = surfaces.at(ix, iy);
    const bool known = is_known(ground);
    surfaces.ground[s] = known ? quantise_height(ground, frame->sensor_z_m) : kNoHeight;
    surfaces.height[s] =
        known ? quantise_height(is_known(elevation) ? elevation : ground, frame->sensor_z_m)
              : kNoHeight;
  }

 private:
  TALUS_HD void infer(int i, int dx, int dy, float bound_m) const
  {
    const LineSearch search = line_search(*config, *frame, store, marks, dx, dy);
    const Fill fill = infer_ground(search, role[i] >= kObject, bound_m, *config);
    if (fill.state == kUnknown) return;  // an older guess, or the object itself, stays
    Cell c = store.load(i);
    place_fill(c, fill, role[i], *config);
    store.store(i, c);
  }
};

}  // namespace talus::kernels
