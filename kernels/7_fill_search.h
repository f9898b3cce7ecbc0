#pragma once
#include "kernels/5_refill.h"
#include "kernels/6_cleanup.h"
#include "kernels/7_fill.h"

namespace talus::kernels
{
// How a device finds the samples of stage 7. Every line, row and column keeps one bit a place,
// "measured ground here", so that finding the next sample is a bit scan.

TALUS_HD int words_per_axis(const Config& k) { return (k.cells + 31) / 32; }
TALUS_HD int words_per_line(const Config& k) { return line_rings(k) / 32 + 1; }

TALUS_HD int lowest_bit(std::uint64_t bits)
{
#if defined(__CUDA_ARCH__)
  return __ffsll(static_cast<long long>(bits)) - 1;
#else
  return __builtin_ctzll(bits);
#endif
}

TALUS_HD std::uint32_t reverse_bits(std::uint32_t bits)
{
#if defined(__CUDA_ARCH__)
  return __brev(bits);
#else
  std::uint32_t reversed = 0;
  for (int b = 0; b < 32; b++) reversed |= (bits >> b & 1u) << (31 - b);
  return reversed;
#endif
}

/** The marks of one line: bit r % 32 of word r / 32 is place r. */
struct LineMarks
{
  const std::uint32_t* word0;
  int stride;  //!< between words
  int last;  //!< place

  static constexpr int kView = 64;

  /** The marks of the places at distances (from, from + kView] on one side of a place, the nearest
   * is bit 0; none beyond `reach`, which must not leave the line. `from` < `reach`. */
  TALUS_HD std::uint64_t view(int place, bool outwards, int from, int reach) const
  {
    const int first = outwards ? place + from + 1 : place - from - 1;
    const int skipped = outwards ? first & 31 : 31 - (first & 31), at = first >> 5;
    const int step = outwards ? 1 : -1;
    const std::uint64_t a = word(at, outwards), b = word(at + step, outwards),
                        c = word(at + 2 * step, outwards);
    const std::uint64_t low = static_cast<std::uint32_t>((a | b << 32) >> skipped);
    const std::uint64_t high = static_cast<std::uint32_t>((b | c << 32) >> skipped);
    const int visible = reach - from;
    const std::uint64_t bits = low | high << 32;
    return visible < kView ? bits & ((std::uint64_t{1} << visible) - 1) : bits;
  }
  /** Distance to the nearest marked place; 0: none within reach. */
  TALUS_HD int nearest(int place, bool outwards, int reach) const
  {
    for (int from = 0; from < reach; from += kView)
      if (const std::uint64_t bits = view(place, outwards, from, reach))
        return from + 1 + lowest_bit(bits);
    return 0;
  }

 private:
  TALUS_HD std::uint64_t word(int at, bool outwards) const
  {
    if (at < 0 || at > last >> 5) return 0;
    const std::uint32_t bits = word0[at * stride];
    return outwards ? bits : reverse_bits(bits);
  }
};

/** A line on the grid and how far fills look along it. */
struct Track
{
  int begin, along;  //!< place 0, and from place to place
  int across;  //!< how lines from the sensor drift: from one row of places to the next
  int drift, rings;  //!< drift / (2 rings) rows from place to place, rounded; 0: no drift
  float inverse;  //!< 1 / (2 rings)
  float step_m;  //!< length per place
  int fill_reach, sparsity_reach;  //!< places

  TALUS_HD int operator()(int place) const
  {
    const int at = begin + place * along;
    if (drift == 0) return at;
    return at + floor_div(drift * place + rings, 2 * rings, inverse) * across;
  }
};

/** A line from the sensor; place = ring. */
TALUS_HD Track radial_track(const Line& l, const LineGrid& grid, const Config& k)
{
  const bool along_x = l.side % 2 == 0;
  const int sign = l.side < 2 ? 1 : -1, rings = grid.half;
  const float step_m = line_stretch(l, rings) * k.resolution_m;
  return {
      grid.middle(),
      along_x ? sign : sign * grid.pitch,
      along_x ? sign * grid.pitch : -sign,
      2 * l.minor,
      rings,
      1.0f / static_cast<float>(2 * rings),
      step_m,
      places_in(k.fill_search_m, step_m, rings),
      places_in(k.sparsity_search_m, step_m, rings)};
}

/** A row or a column; place = ix or iy. */
TALUS_HD Track
axis_track(int across, bool along_x, const LineGrid& grid, int fill_reach, float step_m)
{
  const int begin = along_x ? grid.at(0, across) : grid.at(across, 0);
  return {begin, along_x ? 1 : grid.pitch, 0, 0, 1, 0.5f, step_m, fill_reach, 0};
}

/** What never changes of the lines from the sensor. */
struct LineTables
{
  std::int32_t* line;  //!< through a cell, by place of the grid
  Track* track;  //!< by line
};

struct FillLineTables
{
  const Config* config;
  LineGrid grid;
  LineTables tables;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int rings = grid.half, dx = ix - rings, dy = iy - rings;
    if (dx == 0 && dy == 0) return;
    const int ring = max_of(abs_of(dx), abs_of(dy));
    const int index = line_index(line_through(dx, dy, ring, rings), rings);
    tables.line[grid.at(ix, iy)] = index;
    if (ring == rings)
      tables.track[index] = radial_track(line_from_index(index, rings), grid, *config);
  }
};

/** Whether the cells of a line are samples. Packed into words: bit r of word w is ring 32 * w + r.
 * Layout [word][line]. */
struct SamplesOfLine
{
  const float* height_m;
  const Track& track;

  TALUS_HD bool operator()(int ring) const { return is_known(height_m[track(ring)]); }
};

struct FindSamples
{
  const float* height_m;  //!< see Samples
  const Track* track;

  TALUS_HD SamplesOfLine operator()(int line) const { return {height_m, track[line]}; }
};

/** The last steps before the search, on one cell: its role, the cleanup, and whether it is a
 * sample. */
struct SettleCell
{
  ChooseRole choose;
  CleanUpCell clean;
  float* sample_m;
  LineGrid grid;

  /** True for a sample. */
  TALUS_HD bool operator()(int ix, int iy) const
  {
    const FrameContext& f = *choose.frame;
    const SupportGrid& support = choose.grid;
    const int i = storage_index(f, clean.cells, ix, iy);
    const int px = (ix + f.odd_x) / 2, py = (iy + f.odd_y) / 2;
    choose(i, px, py, support.opened_m[support.at(px, py)]);
    if (clean.concerns(ix, iy, i)) clean(ix, iy, i);
    const bool sample = clean.store.state[i] == kMeasured && clean.role[i] == kKeep;
    sample_m[grid.at(ix, iy)] = sample ? clean.store.ground_m[i] : kNan;
    return sample;
  }
};

/** Everything that the search of one cell along one line needs. */
struct LineSearch
{
  const Config& k;
  const float* sample_m;
  LineMarks marks;
  Track track;
  int place;

  /** `places` cut short where the line ends. */
  TALUS_HD int reach(bool outwards, int places) const
  {
    return min_of(places, outwards ? marks.last - place : place);
  }
  TALUS_HD int at(bool outwards, int distance) const
  {
    return track(outwards ? place + distance : place - distance);
  }

  TALUS_HD SideEstimate infer_side(bool outwards) const
  {
    const int limit = reach(outwards, track.fill_reach);
    SideSum sum;
    float nearest = kNan;
    int nearest_places = 0, wanted = k.fill_samples;
    for (int from = 0; from < limit && wanted > 0; from += LineMarks::kView)
    {
      std::uint64_t bits = marks.view(place, outwards, from, limit);
      while (bits && wanted > 0)
      {
        // Loads first, so that they do not wait for each other.
        int found[kBatch];
        float height[kBatch];
        for (int b = 0; b < kBatch; b++, bits &= bits - 1)
          found[b] = bits && b < wanted ? from + 1 + lowest_bit(bits) : 0;
        for (int b = 0; b < kBatch; b++)
          height[b] = found[b] ? sample_m[at(outwards, found[b])] : 0.0f;
        if (!nearest_places) nearest = height[0], nearest_places = found[0];
        for (int b = 0; b < kBatch; b++)
        {
          sum.add(height[b], static_cast<float>(found[b]) * track.step_m, found[b] > 0, k);
          wanted -= found[b] > 0;
        }
      }
    }
    return nearest_places ? sum.estimate(nearest, nearest_places, track.step_m, k) : SideEstimate{};
  }

 private:
  static constexpr int kBatch = 2;
};

/** Searches the lines through cell (ix, iy) and fills it: the one from the sensor, the row and the
 * column. Their sides may be searched side by side, or one after the other. */
struct SearchAndFillCell
{
  static constexpr int kLines = 3;
  using Side = SideEstimate;
  using Line = LineFusion;
  FillCell fill;
  Config k;
  const float* sample_m;
  const std::uint32_t* marks;
  const std::uint32_t* axis_marks;
  LineTables tables;
  float* across_m;  //!< for guesses: height difference of the ground on both sides, see stage 9
  LineGrid grid;
  int axis_reach;  //!< places that fills look along rows and columns

  TALUS_HD SideEstimate side(int line, bool outwards, int ix, int iy) const
  {
    return wanted(line, ix, iy) ? search(line, ix, iy).infer_side(outwards) : SideEstimate{};
  }
  TALUS_HD LineFusion line(int line, const SideEstimate& inner, const SideEstimate& outer) const
  {
    return k.fill_rule == kFillLines ? fuse_lines(inner, outer, line == 0, k)
                                     : apply_rule(inner, outer, k);
  }
  /** From what the sides of the first line and all lines say. */
  TALUS_HD void operator()(
      int ix, int iy, const SideEstimate& inner, const SideEstimate& outer, const LineFusion* lines,
      int stride) const
  {
    Inference inferred = start(ix, iy, inner, outer, lines[0]);
    if (inferred.any() && k.fill_rule == kFillLines)
      for (int l = 1; l < kLines; l++) inferred.lines.add(lines[l * stride]);
    finish(ix, iy, inferred);
  }

  /** One after the other: where the first line says nothing, the others are not asked. */
  TALUS_HD void operator()(int ix, int iy) const
  {
    Inference inferred;
    for (int l = 0; l < kLines && wanted(l, ix, iy) && (l == 0 || inferred.any()); l++)
    {
      const LineSearch found = search(l, ix, iy);
      const SideEstimate inner = found.infer_side(false), outer = found.infer_side(true);
      if (!inner.any() && !outer.any()) continue;
      const LineFusion fused = line(l, inner, outer);
      if (l == 0)
        inferred = start(ix, iy, inner, outer, fused);
      else
        inferred.lines.add(fused);
    }
    finish(ix, iy, inferred);
  }

 private:
  /** The sensor's own cell lies on no line. */
  TALUS_HD bool on_line(int ix, int iy) const { return ix != grid.half || iy != grid.half; }

  TALUS_HD bool wanted(int line, int ix, int iy) const
  {
    if (!on_line(ix, iy) || (line > 0 && k.fill_rule != kFillLines)) return false;
    return fill.wanted(storage_index(*fill.frame, k.cells, ix, iy));
  }

  TALUS_HD Inference start(
      int ix, int iy, const SideEstimate& inner, const SideEstimate& outer,
      const LineFusion& lines) const
  {
    float inner_m2 = kNan, outer_m2 = kNan;
    if (inner.any()) inner_m2 = variance_of(radial_search(ix, iy), false, inner);
    if (outer.any()) outer_m2 = variance_of(radial_search(ix, iy), true, outer);
    return {lines, fuse_variances(inner_m2, outer_m2)};
  }

  TALUS_HD void finish(int ix, int iy, const Inference& inferred) const
  {
    const int n = k.cells, i = storage_index(*fill.frame, n, ix, iy);
    fill(ix, iy, i, inferred);
    if (on_line(ix, iy) && fill.store.state[i] == kFilledOneSided)
      across_m[grid.at(ix, iy)] = height_across(ix, iy);
    fill.out.put(iy * n + ix, fill.store, i);
  }

  TALUS_HD LineSearch search(int line, int ix, int iy) const
  {
    return line == 0 ? radial_search(ix, iy) : axis_search(ix, iy, line == 1);
  }

  TALUS_HD LineSearch radial_search(int ix, int iy) const
  {
    const int line = tables.line[grid.at(ix, iy)], rings = grid.half;
    const int ring = max_of(abs_of(ix - rings), abs_of(iy - rings));
    return {k, sample_m, {marks + line, 8 * rings, rings}, tables.track[line], ring};
  }

  TALUS_HD LineSearch axis_search(int ix, int iy, bool along_x) const
  {
    const int n = k.cells, across = along_x ? iy : ix;
    return {
        k,
        sample_m,
        {axis_marks + (along_x ? iy : n + ix), 2 * n, n - 1},
        axis_track(across, along_x, grid, axis_reach, k.resolution_m),
        along_x ? ix : iy};
  }

  TALUS_HD float variance_of(
      const LineSearch& radial, bool outwards, const SideEstimate& side) const
  {
    const int place = radial.at(outwards, side.places);
    const int iy = place / grid.pitch, ix = place - iy * grid.pitch;
    const int i = storage_index(*fill.frame, k.cells, ix, iy);
    const float of_sample_m2 = sample_variance(
        side.nearest_m, fill.store.ground_var_m2[i], fill.passing.lowest_m[iy * k.cells + ix]);
    return spread_variance(of_sample_m2, side.distance_m, k);
  }

  TALUS_HD float height_across(int ix, int iy) const
  {
    const LineSearch radial = radial_search(ix, iy);
    const int reach = radial.track.sparsity_reach;
    const int inner = radial.marks.nearest(radial.place, false, radial.reach(false, reach));
    const int outer = radial.marks.nearest(radial.place, true, radial.reach(true, reach));
    if (!inner || !outer) return kNan;
    return abs_of(sample_m[radial.at(false, inner)] - sample_m[radial.at(true, outer)]);
  }
};

}  // namespace talus::kernels
