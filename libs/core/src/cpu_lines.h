#pragma once
#include "cpu_clones.h"
#include "kernels/7_fill.h"

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

  AxisWalk(const kernels::Config& k, int places, std::vector<float>& memory) : k_(k), places_(places)
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

  kernels::LineFusion term(int place, int lane) const { return term_.fusion(place * kLanes + lane); }

 private:
  /** By place and lane: first what one side says, then both. */
  struct Term
  {
    float *a, *b, *c;
    void put(int i, const FirstSide& f) const { a[i] = f.height_m, b[i] = f.places, c[i] = f.distance_m; }
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

/** Lines from the sensor's cell to one half of a side of the grid's border: an eighth of all. */
class RadialWalk
{
 public:
  /** `eighth` in [0, 8). Scratch memory is the caller's. */
  RadialWalk(
      const kernels::Config& k, const kernels::LineGrid& grid, int eighth,
      std::vector<float>& floats, std::vector<int>& ints)
      : k_(k), grid_(grid), rings_(kernels::line_rings(k)), side_(eighth / 2),
        first_line_(eighth % 2 ? 0 : -rings_)
  {
    const auto rings = static_cast<std::size_t>(rings_);
    if (floats.size() < (kMaxSamples + 1) * rings) floats.resize((kMaxSamples + 1) * rings);
    if (ints.size() < (kMaxSamples + 4) * rings) ints.resize((kMaxSamples + 4) * rings);
    float* f = floats.data();
    int* i = ints.data();
    step_m_ = f, height_m_ = f + rings;
    reach_ = i, far_reach_ = i + rings, steps_ = i + 2 * rings, nearest_ = i + 3 * rings;
    place_ = i + 4 * rings;
  }

  template <int kSamples, bool kAlongLines>
  TALUS_CLONES void walk(
      const kernels::Samples& samples, const kernels::InferenceGrid& to) const
  {
    static_assert(kSamples <= kMaxSamples, "");
    const RadialWalk w = *this;
    const Carried<kSamples> carried{height_m_, place_, rings_};
    measure_lines();
    w.clear(carried);
    for (int ring = 0; ring <= rings_; ring++)
    {
      if (ring > 0) w.look_inwards<kAlongLines>(carried, ring, samples, to);
      w.pass(carried, ring, samples);
    }
    w.clear(carried);
    for (int ring = rings_; ring > 0; ring--)
    {
      w.look_outwards<kAlongLines>(carried, ring, samples, to);
      w.pass(carried, ring, samples);
    }
  }

  static constexpr int kMaxSamples = 16;

 private:
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

  void measure_lines() const
  {
    for (int l = 0; l < rings_; l++)
    {
      step_m_[l] = kernels::line_stretch({side_, first_line_ + l}, rings_) * k_.resolution_m;
      reach_[l] = kernels::places_in(k_.fill_search_m, step_m_[l], rings_);
      far_reach_[l] = kernels::places_in(k_.sparsity_search_m, step_m_[l], rings_);
    }
  }

  template <int kSamples>
  void clear(const Carried<kSamples>& carried) const
  {
    carried.clear();
    for (int l = 0; l < rings_; l++) nearest_[l] = grid_.middle();
  }

  /** Which line passes each cell of a ring: as kernels::line_through(). */
  int first_cell(int ring) const { return first_line_ < 0 ? -ring : 0; }
  void find_lines(int ring) const
  {
    const int first = first_cell(ring), rings = rings_, first_line = first_line_;
    const float inverse = 1.0f / static_cast<float>(2 * ring);
    int* const lines = steps_;
    TALUS_INDEPENDENT
    for (int c = 0; c < ring; c++)
      lines[c] =
          kernels::floor_div(2 * (first + c) * rings + ring, 2 * ring, inverse) - first_line;
  }

  template <bool kAlongLines, int kSamples>
  void look_inwards(
      const Carried<kSamples>& carried, int ring, const kernels::Samples& samples,
      const kernels::InferenceGrid& to) const
  {
    find_lines(ring);
    const Row cells = row(ring);
    const int first = first_cell(ring);
    TALUS_INDEPENDENT
    for (int c = 0; c < ring; c++)
    {
      const int l = steps_[c], o = cells.at(first + c);
      const SideEstimate side = carried.infer(l, ring, step_m_[l], reach_[l], k_);
      const float variance = samples.variance_m2[nearest_[l]];
      const FirstSide kept = keep(side, kAlongLines);
      to.inner_var_m2[o] = kernels::select(
          side.any(), kernels::spread_variance(variance, side.distance_m, k_), kernels::kNan);
      to.information[o] = kept.height_m;
      to.weighted[o] = kept.places;
      to.lowest_m[o] = kept.distance_m;
      to.across_m[o] = carried.nearest(l, ring, far_reach_[l]);
    }
  }

  template <bool kAlongLines, int kSamples>
  void look_outwards(
      const Carried<kSamples>& carried, int ring, const kernels::Samples& samples,
      const kernels::InferenceGrid& to) const
  {
    find_lines(ring);
    const Row cells = row(ring);
    const int first = first_cell(ring);
    TALUS_INDEPENDENT
    for (int c = 0; c < ring; c++)
    {
      const int l = steps_[c], o = cells.at(first + c);
      const SideEstimate side = carried.infer(l, ring, step_m_[l], reach_[l], k_);
      const float variance = samples.variance_m2[nearest_[l]];
      const FirstSide kept{to.information[o], to.weighted[o], to.lowest_m[o]};
      const SideEstimate inner = recall(kept, step_m_[l], kAlongLines);
      to.store(o, kAlongLines ? kernels::fuse_lines(inner, side) : kernels::apply_rule(inner, side, k_));
      to.outer_var_m2[o] = kernels::select(
          side.any(), kernels::spread_variance(variance, side.distance_m, k_), kernels::kNan);
      to.across_m[o] =
          kernels::abs_of(to.across_m[o] - carried.nearest(l, ring, far_reach_[l]));
    }
  }

  /** Each line meets its cell of a ring: as kernels::line_cell(). */
  template <int kSamples>
  void pass(const Carried<kSamples>& carried, int ring, const kernels::Samples& samples) const
  {
    const Row cells = row(ring);
    const int rings = rings_, first_line = first_line_;
    const float inverse = 1.0f / static_cast<float>(2 * rings);
    TALUS_INDEPENDENT
    for (int l = 0; l < rings; l++)
    {
      const int minor =
          kernels::floor_div(2 * (first_line + l) * ring + rings, 2 * rings, inverse);
      const int o = cells.at(minor);
      const float sample = samples.height_m[o];
      const int before = nearest_[l];
      nearest_[l] = kernels::select(kernels::is_known(sample), o, before);
      carried.push(l, sample, ring);
    }
  }

  const kernels::Config& k_;
  kernels::LineGrid grid_;
  int rings_, side_, first_line_;
  // by line
  float *step_m_, *height_m_;
  int *reach_, *far_reach_, *nearest_, *place_;
  int* steps_;  //!< by cell of a ring: its line
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
