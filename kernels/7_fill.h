#pragma once
#include "kernels/rays.h"

namespace talus::kernels
{
// Stage 7 (III-B.3): ground of cells that were not measured, from samples found along the line to
// the sensor: towards it and away from it. Each line keeps one bit a ring, "measured ground here";
// finding the next sample is then a bit scan instead of a walk.

TALUS_HD int words_per_axis(const Config& k) { return (k.cells + 31) / 32; }
TALUS_HD int words_per_line(const Config& k) { return line_rings(k) / 32 + 1; }

/** Whether the cells of a line are ground that fills may build on. Packed into words: bit r of word
 * w is ring 32 * w + r. Layout [word][line]. */
struct SamplesOfLine
{
  const FrameContext* frame;
  const std::uint8_t* state;
  const std::uint8_t* role;
  Line line;
  int rings, cells;

  TALUS_HD bool operator()(int ring) const
  {
    const CellOffset o = line_cell(line, ring, rings);
    const int ix = cells / 2 + o.dx, iy = cells / 2 + o.dy;
    if (ix >= cells || iy >= cells || ix < 0 || iy < 0) return false;
    const int i = storage_index(*frame, cells, ix, iy);
    return state[i] == kMeasured && role[i] == kKeep;
  }
};

struct FindSamples
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const std::uint8_t* role;

  TALUS_HD SamplesOfLine operator()(int line) const
  {
    const int rings = line_rings(*config);
    return {frame, store.state, role, line_from_index(line, rings), rings, config->cells};
  }
};

/** The same for a row or a column of the window; bit r of word w is ix or iy = 32 * w + r. */
struct SamplesOfAxis
{
  const FrameContext* frame;
  const std::uint8_t* state;
  const std::uint8_t* role;
  int across, cells;
  bool along_x;

  TALUS_HD bool operator()(int at) const
  {
    const int i = along_x ? storage_index(*frame, cells, at, across)
                          : storage_index(*frame, cells, across, at);
    return state[i] == kMeasured && role[i] == kKeep;
  }
};

/** Lines are the rows, then the columns. */
struct FindAxisSamples
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const std::uint8_t* role;

  TALUS_HD SamplesOfAxis operator()(int line) const
  {
    const int n = config->cells;
    return {frame, store.state, role, line < n ? line : line - n, n, line < n};
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
  float mean_m = kNan;  //!< kernel-weighted mean of the samples ...
  float mean_distance_m = 0;  //!< ... and where it lies

  TALUS_HD bool any() const { return is_known(nearest_m); }
};

/** Where the cells of a line from the sensor are: place = ring. */
struct RadialCells
{
  Line line;
  int rings;
  TALUS_HD CellOffset operator()(int ring) const { return line_cell(line, ring, rings); }
};

/** Where the cells of a row or column are: place = ix or iy; offsets from the sensor's cell. */
struct AxisCells
{
  int half, across;
  bool along_x;
  TALUS_HD CellOffset operator()(int place) const
  {
    return along_x ? CellOffset{place - half, across} : CellOffset{across, place - half};
  }
};

/** Everything that the search of one cell along one line needs. */
template <class Cells>
struct LineSearch
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  Cells cells;
  LineMarks marks;
  int place;
  float step_m;  //!< length of the line per place

  TALUS_HD int storage_at(int at) const
  {
    const int n = config->cells;
    const CellOffset o = cells(at);
    return storage_index(*frame, n, n / 2 + o.dx, n / 2 + o.dy);
  }

  /** How many places a distance is. */
  TALUS_HD int places_in(float distance_m) const
  {
    return floor_to_int(min_of(distance_m / step_m, static_cast<float>(marks.rings)));
  }

  TALUS_HD int next(int from, bool outwards, float reach_m) const
  {
    return outwards ? marks.outwards(from, place + places_in(reach_m))
                    : marks.inwards(from, max_of(place - places_in(reach_m), 0));
  }

  /** Eq. 8: sparse kernel inference with the lowest sample as the prior. */
  TALUS_HD SideEstimate infer_side(bool outwards) const
  {
    SideEstimate side;
    float weights = 0, weighted = 0, lowest = kInfinity, lengths = 0;
    int at = place;
    for (int s = 0; s < config->fill_samples; s++)
    {
      at = next(at, outwards, config->fill_search_m);
      if (at < 0) break;
      const int i = storage_at(at);
      const float height = store.ground_m[i];
      const float distance = static_cast<float>(abs_of(at - place)) * step_m;
      if (s == 0)
      {
        side.gap_cells = abs_of(at - place) - 1;
        side.distance_m = distance;
        side.nearest_m = height;
        const float spread = config->fill_variance_per_m * distance;
        side.variance_m2 = store.ground_var_m2[i] + spread * spread;
      }
      const float w = kernel_weight(distance);
      weights += w;
      weighted += w * height;
      lengths += w * distance;
      lowest = min_of(lowest, height);
    }
    if (lowest == kInfinity) return side;
    side.height_m = (config->fill_lambda * lowest + weighted) / (config->fill_lambda + weights);
    side.mean_m = weights > 0.0f ? weighted / weights : side.nearest_m;
    side.mean_distance_m = weights > 0.0f ? lengths / weights : side.distance_m;
    return side;
  }

  TALUS_HD float kernel_weight(float distance_m) const
  {
    const int i = floor_to_int(
        distance_m * config->inverse_fill_kernel * static_cast<float>(kKernelTableSize));
    return i < kKernelTableSize ? config->fill_kernel[i] : 0.0f;
  }
};

TALUS_HD LineSearch<RadialCells> line_search(
    const Config& k, const FrameContext& f, const CellStore& store, const std::uint32_t* marks,
    int dx, int dy)
{
  const int rings = line_rings(k);
  const int ring = max_of(abs_of(dx), abs_of(dy));
  const Line line = line_through(dx, dy, ring, rings);
  const LineMarks line_marks{marks + line_index(line, rings), line_count(k), rings};
  const float step_m = line_stretch(line, rings) * k.resolution_m;
  return {&k, &f, store, {line, rings}, line_marks, ring, step_m};
}

TALUS_HD LineSearch<AxisCells> axis_search(
    const Config& k, const FrameContext& f, const CellStore& store, const std::uint32_t* axis_marks,
    int dx, int dy, bool along_x)
{
  const int half = k.cells / 2;
  const int place = half + (along_x ? dx : dy), across = along_x ? dy : dx;
  const int line = half + across + (along_x ? 0 : k.cells);
  const LineMarks line_marks{axis_marks + line, 2 * k.cells, k.cells - 1};
  return {&k, &f, store, {half, across, along_x}, line_marks, place, k.resolution_m};
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

/** What was inferred for a cell. */
struct Fill
{
  float height_m = kNan;
  float variance_m2 = kNan;
  std::uint8_t state = kUnknown;
};

/** Heights of several lines, each weighed by how far it has to bridge. */
struct LineFusion
{
  float information = 0, weighted = 0, lowest_m = kInfinity;

  /** Between samples of both sides linearly, beside one side level. The error grows with the
   * distances. */
  TALUS_HD void add(const SideEstimate& a, const SideEstimate& b)
  {
    const bool has_a = a.any(), has_b = b.any();
    if (has_a && has_b)
    {
      const float span = a.mean_distance_m + b.mean_distance_m;
      add(a.mean_m + (b.mean_m - a.mean_m) * (a.mean_distance_m / span),
          0.1f * a.distance_m * b.distance_m / (a.distance_m + b.distance_m));
    }
    else if (has_a || has_b)
    {
      const SideEstimate& side = has_a ? a : b;
      add(side.mean_m, 0.3f * side.distance_m);
    }
  }

  TALUS_HD void add(float height_m, float deviation_m)
  {
    const float d = 0.002f + deviation_m;
    information += 1.0f / (d * d);
    weighted += height_m / (d * d);
    lowest_m = min_of(lowest_m, height_m);
  }
};

TALUS_HD Fill infer_ground(
    const SideEstimate& inner, const SideEstimate& outer, const LineFusion& lines,
    bool under_object, float bound_m, const Config& k)
{
  const bool has_inner = inner.any(), has_outer = outer.any();
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
  if (k.fill_rule == kFillLines)
    fill.height_m = under_object ? lines.lowest_m : lines.weighted / lines.information;
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

constexpr std::int32_t kNoHeight = -0x7fffffff - 1;

/** The surfaces of one cell, quantised, for stage 8. */
struct alignas(8) Surface
{
  std::int32_t ground;  //!< kNoHeight: unknown
  /** Twice the elevation, or the ground where nothing stands; plus 1 where the ground is measured.
   */
  std::int32_t height_and_measured;

  TALUS_HD bool known() const { return ground != kNoHeight; }
  TALUS_HD std::int32_t height() const { return height_and_measured >> 1; }
  TALUS_HD std::int32_t measured() const { return height_and_measured & 1; }
};

/** Window order; columns padded by the feature radius. */
struct Surfaces
{
  Surface* cell;
  int pitch, pad;

  TALUS_HD int at(int ix, int iy) const { return iy * pitch + ix + pad; }
};

/** Stage 7 on cell (ix, iy). */
struct FillCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const std::uint8_t* role;
  const std::uint32_t* marks;
  const std::uint32_t* axis_marks;
  const float* ray_bound_m;
  Surfaces surfaces;
  SurfaceLayers out;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int n = config->cells;
    const int i = storage_index(*frame, n, ix, iy);
    const int dx = ix - n / 2, dy = iy - n / 2;
    if (role[i] != kKeep && (dx != 0 || dy != 0)) infer(i, dx, dy, ray_bound_m[iy * n + ix]);

    const float ground_m = store.ground_m[i];
    // Behind something that was hit only a ray below the height of a step proves that the ground is
    // free; before everything that was hit (the blind zone around the robot) the clearance will do.
    const float proof_m =
        store.passed[i] & kInOpen ? config->clearance_m : config->step_threshold_m;
    if (ray_bound_m[iy * n + ix] < ground_m + proof_m) store.passed[i] |= kPassedLow;
    surfaces.cell[surfaces.at(ix, iy)] = surface_of(i);
    out.put(iy * n + ix, store, i);
  }

 private:
  TALUS_HD Surface surface_of(int i) const
  {
    const float ground = store.ground_m[i], elevation = store.elevation_m[i];
    if (!is_known(ground)) return {kNoHeight, 0};
    const std::int32_t height =
        quantise_height(is_known(elevation) ? elevation : ground, frame->sensor_z_m);
    return {quantise_height(ground, frame->sensor_z_m), 2 * height + (store.state[i] == kMeasured)};
  }

  TALUS_HD void infer(int i, int dx, int dy, float bound_m) const
  {
    const auto radial = line_search(*config, *frame, store, marks, dx, dy);
    const SideEstimate inner = radial.infer_side(false), outer = radial.infer_side(true);
    if (!inner.any() && !outer.any()) return;  // an older guess, or the object itself, stays
    LineFusion lines;
    if (config->fill_rule == kFillLines)
    {
      lines.add(inner, outer);
      for (int axis = 0; axis < 2; axis++)
      {
        const auto search = axis_search(*config, *frame, store, axis_marks, dx, dy, axis == 0);
        lines.add(search.infer_side(false), search.infer_side(true));
      }
    }
    const Fill fill = infer_ground(inner, outer, lines, role[i] >= kObject, bound_m, *config);
    Cell c = store.load(i);
    place_fill(c, fill, role[i], *config);
    store.store(i, c);
  }
};

}  // namespace talus::kernels
