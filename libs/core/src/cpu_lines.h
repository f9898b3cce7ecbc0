#pragma once
#include "cpu_clones.h"
#include "kernels/7_fill.h"

#include <algorithm>
#include <vector>

// Stage 7's lines on the CPU: many lines are walked side by side, each with the samples that it met
// last, so that a cell costs the same however far its samples are, and loops over lines vectorise.

namespace talus::lines
{
using kernels::SideEstimate;

/** Where a sample is that was never met. */
constexpr int kNowhere = -(1 << 20);

/** The last kSamples samples of each of `lanes` lines. */
template <int kSamples>
struct Carried
{
  float* height_m;  //!< [sample][lane], the last first
  int* place;  //!< likewise
  int lanes;

  void clear() const
  {
    for (int i = 0; i < kSamples * lanes; i++) height_m[i] = 0, place[i] = kNowhere;
  }

  void push(int lane, float sample_m, int at) const
  {
    const bool known = kernels::is_known(sample_m);
    for (int s = kSamples - 1; s >= 0; s--)
    {
      const int i = s * lanes + lane;
      const float older_m = height_m[i], newer_m = s ? height_m[i - lanes] : sample_m;
      const int older = place[i], newer = s ? place[i - lanes] : at;
      height_m[i] = kernels::select(known, newer_m, older_m);
      place[i] = kernels::select(known, newer, older);
    }
  }

  /** What the samples say of a place within `reach` places of the last. */
  SideEstimate infer(int lane, int at, float step_m, int reach, const kernels::Config& k) const
  {
    kernels::SideSum sum;
    const int samples = k.fill_samples;
    for (int s = 0; s < kSamples; s++)
    {
      const int places = kernels::abs_of(at - place[s * lanes + lane]);
      const bool inside = (places <= reach) & (s < samples);
      const float distance = static_cast<float>(kernels::select(inside, places, 0)) * step_m;
      sum.add(height_m[s * lanes + lane], distance, inside, k);
    }
    const int places = kernels::abs_of(at - place[lane]);
    const bool any = places <= reach;
    const float nearest = height_m[lane];
    return sum.estimate(
        kernels::select(any, nearest, kernels::kNan), kernels::select(any, places, 0), step_m, k);
  }

  /** Height of the last sample, NaN if it is not within `reach` places. */
  float nearest(int lane, int at, int reach) const
  {
    const float height = height_m[lane];
    return kernels::select(kernels::abs_of(at - place[lane]) <= reach, height, kernels::kNan);
  }
};

/** What is kept of the first side of a cell until the second is known. */
struct FirstSide
{
  float height_m;  //!< NaN: no samples; mean height, or mu* where the rule is not kFillLines
  float places;
  float distance_m;  //!< of the mean; height of the nearest where the rule is not kFillLines
};

inline FirstSide keep(const SideEstimate& side, bool along_lines)
{
  const float height = along_lines ? side.mean_m : side.height_m;
  return {
      kernels::select(side.any(), height, kernels::kNan), static_cast<float>(side.places),
      along_lines ? side.mean_distance_m : side.nearest_m};
}

inline SideEstimate recall(const FirstSide& first, float step_m, bool along_lines)
{
  SideEstimate side;
  side.places = static_cast<int>(first.places);
  side.distance_m = first.places * step_m;
  side.height_m = side.mean_m = first.height_m;
  side.nearest_m = along_lines ? first.height_m : first.distance_m;
  side.mean_distance_m = first.distance_m;
  return side;
}

/** Lines that run beside each other along rows or columns. */
class AxisWalk
{
 public:
  static constexpr int kLanes = kernels::kGridStrip;

  AxisWalk(const kernels::Config& k, int places, std::vector<float>& memory)
      : k_(k), places_(places)
  {
    const auto size = static_cast<std::size_t>(places) * kLanes;
    if (memory.size() < 3 * size) memory.resize(3 * size);
    term_ = {memory.data(), memory.data() + size, memory.data() + 2 * size};
  }

  /** `samples`: of the lines at a place; `pitch` floats from one place to the next. */
  template <int kSamples>
  TALUS_CLONES void walk(const float* samples, std::ptrdiff_t pitch) const
  {
    alignas(64) float height[kSamples * kLanes];
    alignas(64) int place[kSamples * kLanes];
    const Carried<kSamples> carried{height, place, kLanes};
    const Term term = term_;
    const kernels::Config& k = k_;
    const float step_m = k.resolution_m;
    const int reach = kernels::places_in(k.fill_search_m, step_m, k.cells - 1), places = places_;
    carried.clear();
    for (int at = 0; at < places; at++)
    {
      const float* here = samples + at * pitch;
      TALUS_INDEPENDENT
      for (int l = 0; l < kLanes; l++)
      {
        term.put(at * kLanes + l, keep(carried.infer(l, at, step_m, reach, k), true));
        carried.push(l, here[l], at);
      }
    }
    carried.clear();
    for (int at = places - 1; at >= 0; at--)
    {
      const float* here = samples + at * pitch;
      TALUS_INDEPENDENT
      for (int l = 0; l < kLanes; l++)
      {
        const SideEstimate low = recall(term.first(at * kLanes + l), step_m, true);
        kernels::LineFusion both;
        both.add(low, carried.infer(l, at, step_m, reach, k));
        term.put(at * kLanes + l, both);
        carried.push(l, here[l], at);
      }
    }
  }

  kernels::LineFusion term(int place, int lane) const
  {
    return term_.fusion(place * kLanes + lane);
  }

 private:
  /** By place and lane: first what one side says, then both. */
  struct Term
  {
    float *a, *b, *c;
    void put(int i, const FirstSide& f) const
    {
      a[i] = f.height_m, b[i] = f.places, c[i] = f.distance_m;
    }
    FirstSide first(int i) const { return {a[i], b[i], c[i]}; }
    void put(int i, const kernels::LineFusion& f) const
    {
      a[i] = f.information, b[i] = f.weighted, c[i] = f.lowest_m;
    }
    kernels::LineFusion fusion(int i) const { return {a[i], b[i], c[i]}; }
  };
  const kernels::Config& k_;
  int places_;
  Term term_;
};

/** Lines from the sensor's cell to one half of a side of the grid's border: an eighth of all. Cells
 * and lines are taken in whole blocks; what is too much is computed and dropped. */
class RadialWalk
{
 public:
  static constexpr int kMaxSamples = 16;

  /** `eighth` in [0, 8). Scratch memory is the caller's. */
  RadialWalk(
      const kernels::Config& k, const kernels::LineGrid& grid, int eighth,
      std::vector<float>& floats, std::vector<int>& ints)
      : k_(k),
        grid_(grid),
        rings_(kernels::line_rings(k)),
        lanes_(whole_blocks(rings_)),
        side_(eighth / 2),
        first_line_(eighth % 2 ? 0 : -rings_)
  {
    const auto lanes = static_cast<std::size_t>(lanes_);
    const auto kept = static_cast<std::size_t>(kept_at(rings_ + 1));
    floats.resize(std::max(floats.size(), (kMaxSamples + 1) * lanes + kLayers * kept));
    ints.resize(std::max(ints.size(), (kMaxSamples + 4) * lanes));
    float* f = floats.data();
    int* i = ints.data();
    step_m_ = f, height_m_ = f + lanes, kept_ = height_m_ + kMaxSamples * lanes;
    reach_ = i, far_reach_ = i + lanes, line_of_ = i + 2 * lanes, nearest_ = i + 3 * lanes;
    place_ = i + 4 * lanes;
  }

  template <int kSamples, bool kAlongLines>
  void walk(const kernels::Samples& samples, const kernels::InferenceGrid& to) const
  {
    static_assert(kSamples <= kMaxSamples, "");
    const Carried<kSamples> carried{height_m_, place_, lanes_};
    measure_lines();
    clear(carried);
    for (int ring = 0; ring <= rings_; ring++)
    {
      if (ring > 0) look_inwards<kAlongLines>(carried, ring, samples);
      pass(carried, ring, samples);
    }
    clear(carried);
    for (int ring = rings_; ring > 0; ring--)
    {
      look_outwards<kAlongLines>(carried, ring, samples);
      put_ring(ring, to);
      pass(carried, ring, samples);
    }
  }

 private:
  static constexpr int kBlock = 16;
  static constexpr int whole_blocks(int n) { return (n + kBlock - 1) / kBlock * kBlock; }

  /** The layers of kernels::InferenceGrid. */
  static constexpr int kLayers = 6;
  enum
  {
    kInformation,
    kWeighted,
    kLowest,
    kInnerVar,
    kOuterVar,
    kAcross
  };

  /** A ring's cells on this half of the side, as places of the grid. */
  struct Row
  {
    int first, stride;
    int at(int minor) const { return first + minor * stride; }
  };
  Row row(int ring) const
  {
    const int middle = grid_.middle(), pitch = grid_.pitch;
    switch (side_)
    {
      case 0:
        return {middle + ring, pitch};
      case 1:
        return {middle + ring * pitch, -1};
      case 2:
        return {middle - ring, -pitch};
      default:
        return {middle - ring * pitch, 1};
    }
  }
  /** The first of a ring's cells. */
  int first_cell(int ring) const { return first_line_ < 0 ? -ring : 0; }
  /** Outer rings have about as many cells as there are lines: what they need is computed for every
   * line, in their order. On inner rings it is computed for the lines that pass their cells. */
  bool by_line(int ring) const { return 2 * ring > rings_; }
  /** Where what is kept of a ring begins, of each layer. */
  int kept_at(int ring) const
  {
    const int inner = kernels::min_of(ring, rings_ / 2 + 1);
    return (inner * (inner - 1)) / 2 + kBlock * inner + (ring - inner) * lanes_;
  }
  float* kept(int layer, int ring) const
  {
    return kept_ + layer * kept_at(rings_ + 1) + kept_at(ring);
  }

  void measure_lines() const
  {
    for (int l = 0; l < lanes_; l++)
    {
      const int line = first_line_ + kernels::min_of(l, rings_ - 1);
      step_m_[l] = kernels::line_stretch({side_, line}, rings_) * k_.resolution_m;
      reach_[l] = kernels::places_in(k_.fill_search_m, step_m_[l], rings_);
      far_reach_[l] = kernels::places_in(k_.sparsity_search_m, step_m_[l], rings_);
    }
  }

  template <int kSamples>
  void clear(const Carried<kSamples>& carried) const
  {
    carried.clear();
    for (int l = 0; l < lanes_; l++) nearest_[l] = grid_.middle();
  }

  struct EveryLine
  {
    int operator()(int i) const { return i; }
  };
  struct ListedLine
  {
    const int* lines;
    int operator()(int i) const { return lines[i]; }
  };

  /** Which line passes each cell of a ring: as kernels::line_through(). */
  void find_lines(int ring) const
  {
    const int first = first_cell(ring), rings = rings_, first_line = first_line_;
    const float inverse = 1.0f / static_cast<float>(2 * ring);
    int* const line_of = line_of_;
    const int cells = whole_blocks(ring);
    TALUS_INDEPENDENT
    for (int c = 0; c < cells; c++)
    {
      const int cell = first + kernels::min_of(c, ring - 1);
      line_of[c] = kernels::floor_div(2 * cell * rings + ring, 2 * ring, inverse) - first_line;
    }
  }

  template <bool kAlongLines, int kSamples>
  TALUS_CLONES void look_inwards(
      Carried<kSamples> carried, int ring, kernels::Samples samples) const
  {
    if (by_line(ring))
      return look_inwards_from<kAlongLines>(EveryLine{}, lanes_, carried, ring, samples);
    find_lines(ring);
    look_inwards_from<kAlongLines>(
        ListedLine{line_of_}, whole_blocks(ring), carried, ring, samples);
  }
  template <bool kAlongLines, class LineOf, int kSamples>
  void look_inwards_from(
      LineOf line_of, int cells, const Carried<kSamples>& carried, int ring,
      const kernels::Samples& samples) const
  {
    const kernels::Config& k = k_;
    const int* const nearest = nearest_;
    const int *const reach = reach_, *const far_reach = far_reach_;
    const float *const step_m = step_m_, *const variance_m2 = samples.variance_m2;
    float *const a = kept(kInformation, ring), *const b = kept(kWeighted, ring);
    float *const d = kept(kLowest, ring), *const var = kept(kInnerVar, ring);
    float* const across = kept(kAcross, ring);
    TALUS_INDEPENDENT
    for (int c = 0; c < cells; c++)
    {
      const int l = line_of(c);
      const SideEstimate side = carried.infer(l, ring, step_m[l], reach[l], k);
      const FirstSide first = keep(side, kAlongLines);
      a[c] = first.height_m, b[c] = first.places, d[c] = first.distance_m;
      var[c] = variance(side, variance_m2[nearest[l]], k);
      across[c] = carried.nearest(l, ring, far_reach[l]);
    }
  }

  template <bool kAlongLines, int kSamples>
  TALUS_CLONES void look_outwards(
      Carried<kSamples> carried, int ring, kernels::Samples samples) const
  {
    if (by_line(ring))
      return look_outwards_from<kAlongLines>(EveryLine{}, lanes_, carried, ring, samples);
    find_lines(ring);
    look_outwards_from<kAlongLines>(
        ListedLine{line_of_}, whole_blocks(ring), carried, ring, samples);
  }
  template <bool kAlongLines, class LineOf, int kSamples>
  void look_outwards_from(
      LineOf line_of, int cells, const Carried<kSamples>& carried, int ring,
      const kernels::Samples& samples) const
  {
    const kernels::Config& k = k_;
    const int* const nearest = nearest_;
    const int *const reach = reach_, *const far_reach = far_reach_;
    const float *const step_m = step_m_, *const variance_m2 = samples.variance_m2;
    float *const a = kept(kInformation, ring), *const b = kept(kWeighted, ring);
    float *const d = kept(kLowest, ring), *const var = kept(kOuterVar, ring);
    float* const across = kept(kAcross, ring);
    TALUS_INDEPENDENT
    for (int c = 0; c < cells; c++)
    {
      const int l = line_of(c);
      const SideEstimate side = carried.infer(l, ring, step_m[l], reach[l], k);
      const SideEstimate inner = recall({a[c], b[c], d[c]}, step_m[l], kAlongLines);
      const kernels::LineFusion both =
          kAlongLines ? kernels::fuse_lines(inner, side) : kernels::apply_rule(inner, side, k);
      a[c] = both.information, b[c] = both.weighted, d[c] = both.lowest_m;
      var[c] = variance(side, variance_m2[nearest[l]], k);
      across[c] = kernels::abs_of(across[c] - carried.nearest(l, ring, far_reach[l]));
    }
  }

  static float variance(const SideEstimate& side, float of_sample_m2, const kernels::Config& k)
  {
    return kernels::select(
        side.any(), kernels::spread_variance(of_sample_m2, side.distance_m, k), kernels::kNan);
  }

  /** What was found for a ring goes to the grid. */
  TALUS_CLONES void put_ring(int ring, kernels::InferenceGrid to) const
  {
    const Row cells = row(ring);
    float* const layers[kLayers] = {to.information,  to.weighted,     to.lowest_m,
                                    to.inner_var_m2, to.outer_var_m2, to.across_m};
    const bool listed = by_line(ring);
    if (listed) find_lines(ring);
    for (int layer = 0; layer < kLayers; layer++)
    {
      const float* from = kept(layer, ring);
      float* at = layers[layer] + cells.at(first_cell(ring));
      for (int c = 0; c < ring; c++, at += cells.stride) *at = from[listed ? line_of_[c] : c];
    }
  }

  /** Each line meets its cell of a ring: as kernels::line_cell(). */
  template <int kSamples>
  TALUS_CLONES void pass(Carried<kSamples> carried, int ring, kernels::Samples samples) const
  {
    int* const nearest = nearest_;
    const Row cells = row(ring);
    const int rings = rings_, first_line = first_line_, lanes = lanes_;
    const float inverse = 1.0f / static_cast<float>(2 * rings);
    TALUS_INDEPENDENT
    for (int l = 0; l < lanes; l++)
    {
      const int line = first_line + kernels::min_of(l, rings - 1);
      const int minor = kernels::floor_div(2 * line * ring + rings, 2 * rings, inverse);
      const int o = cells.at(minor), before = nearest[l];
      const float sample = samples.height_m[o];
      nearest[l] = kernels::select(kernels::is_known(sample), o, before);
      carried.push(l, sample, ring);
    }
  }

  const kernels::Config& k_;
  kernels::LineGrid grid_;
  int rings_, lanes_, side_, first_line_;
  // by line
  float *step_m_, *height_m_;
  int *reach_, *far_reach_, *nearest_, *place_;
  int* line_of_;  //!< by cell of a ring
  float* kept_;  //!< by layer, ring and cell
};

/** Rows, then columns of a grid, AxisWalk::kLanes at a time, are added to what the rays say. */
struct WalkRows
{
  const kernels::Config& k;
  kernels::LineGrid grid;
  kernels::Samples samples;
  kernels::InferenceGrid to;

  template <int kSamples>
  TALUS_CLONES void walk(int strip) const
  {
    constexpr int kLanes = AxisWalk::kLanes;
    static thread_local std::vector<float> memory, across;
    const int first = strip * kLanes, lanes = kernels::min_of(kLanes, grid.side - first);
    across.resize(static_cast<std::size_t>(grid.side) * kLanes);
    float* turned = across.data();
    for (int l = 0; l < lanes; l++)
      for (int x = 0; x < grid.side; x++)
        turned[x * kLanes + l] = samples.height_m[grid.at(x, first + l)];
    AxisWalk lines(k, grid.side, memory);
    lines.walk<kSamples>(turned, kLanes);
    for (int l = 0; l < lanes; l++)
    {
      TALUS_INDEPENDENT
      for (int x = 0; x < grid.side; x++) to.add(grid.at(x, first + l), lines.term(x, l));
    }
  }
};

struct WalkColumns
{
  const kernels::Config& k;
  kernels::LineGrid grid;
  kernels::Samples samples;
  kernels::InferenceGrid to;

  template <int kSamples>
  TALUS_CLONES void walk(int strip) const
  {
    constexpr int kLanes = AxisWalk::kLanes;
    static thread_local std::vector<float> memory;
    AxisWalk lines(k, grid.side, memory);
    lines.walk<kSamples>(samples.height_m + strip * kLanes, grid.pitch);
    for (int y = 0; y < grid.side; y++)
    {
      TALUS_INDEPENDENT
      for (int l = 0; l < kLanes; l++) to.add(grid.at(strip * kLanes + l, y), lines.term(y, l));
    }
  }
};

struct WalkRays
{
  const kernels::Config& k;
  kernels::LineGrid grid;
  kernels::Samples samples;
  kernels::InferenceGrid to;

  template <int kSamples>
  void walk(int eighth) const
  {
    static thread_local std::vector<float> floats;
    static thread_local std::vector<int> ints;
    const RadialWalk rays(k, grid, eighth, floats, ints);
    if (k.fill_rule == kernels::kFillLines)
      rays.walk<kSamples, true>(samples, to);
    else
      rays.walk<kSamples, false>(samples, to);
  }
};

/** f.walk() with room for as many samples as are wanted. */
template <class F>
struct Walk
{
  F f;
  void operator()(int part) const
  {
    if (f.k.fill_samples <= 4)
      f.template walk<4>(part);
    else
      f.template walk<RadialWalk::kMaxSamples>(part);
  }
};

}  // namespace talus::lines
