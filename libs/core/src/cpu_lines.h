#pragma once
#include "cpu_clones.h"
#include "kernels/7_fill.h"

#include <algorithm>
#include <cstring>
#include <vector>

// Stage 7's lines on the CPU. Each line is walked once: it lists its samples, and each of its cells
// to infer notes how many there were when the line came by. So a cell costs the same however far
// its samples are, only cells that need it are inferred, and many of them at once in vector code.

namespace talus::lines
{
using kernels::SideEstimate;

/** Where a sample is that was never met. */
constexpr int kNowhere = -(1 << 20);
/** Compiled for the default and for any number. */
constexpr int kFewSamples = 2, kMaxSamples = 16;
/** How many lines are one part of the work. */
constexpr int kLinesOfPart = 16;

/** Memory of this thread, kept from frame to frame. */
template <class T>
class Scratch
{
 public:
  explicit Scratch(std::size_t size)
  {
    if (memory().size() < size) memory().resize(size);
    next_ = memory().data();
  }
  T* take(std::size_t size)
  {
    next_ += size;
    return next_ - size;
  }

 private:
  static std::vector<T>& memory()
  {
    static thread_local std::vector<T> m;
    return m;
  }
  T* next_;
};

/** A line on its way over the grid: where it reads samples and which cell of the grid that is, by
 * place; which of the cells are its own to infer. */
struct Track
{
  const float* height_m;
  int *read, *cell, *own;
  int places;
  float step_m;  //!< length of the line per place
};

/** The samples that a line met, in order, between kSamples that are nowhere. */
template <int kSamples>
struct Met
{
  float* height_m;
  int *place, *cell;
};

/** Cells to infer, from several lines. */
template <int kSamples>
struct Batch
{
  static constexpr int kBoth = 2 * kSamples;
  // what is known of each: the samples around it, the last of those before it at kSamples - 1
  float* height_m;
  int* place;
  int *at, *to;  //!< place on the line; on the grid
  float *step_m, *before_m2, *behind_m2;  //!< variances of the samples next to it
  // what is inferred
  kernels::Inference* found;
  float* across_m;

  /** From the samples before (direction -1) or behind a cell (1). */
  SideEstimate infer(int c, int direction, float step, int reach, const kernels::Config& k) const
  {
    const int nearest = c * kBoth + kSamples - (direction < 0);
    kernels::SideSum sum;
    for (int s = 0; s < kSamples; s++)
    {
      const int places = kernels::abs_of(at[c] - place[nearest + s * direction]);
      const bool inside = (places <= reach) & (s < k.fill_samples);
      const float distance = static_cast<float>(kernels::select(inside, places, 0)) * step;
      sum.add(height_m[nearest + s * direction], distance, inside, k);
    }
    const int places = kernels::abs_of(at[c] - place[nearest]);
    const bool any = places <= reach;
    return sum.estimate(
        kernels::select(any, height_m[nearest], kernels::kNan), kernels::select(any, places, 0),
        step, k);
  }

  /** Height of the nearest of them, NaN if it is not within `reach` places. */
  float nearest(int c, int direction, int reach) const
  {
    const int i = c * kBoth + kSamples - (direction < 0);
    const bool near = kernels::abs_of(at[c] - place[i]) <= reach;
    return kernels::select(near, height_m[i], kernels::kNan);
  }
};

template <int kSamples, bool kAlongRays>
class LineSearch
{
 public:
  /** `places`: of the longest line. */
  LineSearch(
      const kernels::Config& k, const float* variance_m2, const kernels::InferenceGrid& to,
      int places)
      : k_(k), variance_m2_(variance_m2), to_(to)
  {
    const auto line = static_cast<std::size_t>(places), met = line + 2 * kSamples + 1;
    const auto room = static_cast<std::size_t>(kEnough) + line + kBlock, both = kBoth * room;
    Scratch<float> f(met + both + 4 * room);
    Scratch<int> i(3 * line + 2 * met + 2 * (line + 1) + both + 2 * room);
    Scratch<kernels::Inference> found(room);
    track_ = {nullptr, i.take(line), i.take(line), i.take(line), 0, 0};
    met_ = {f.take(met), i.take(met), i.take(met)};
    next_ = i.take(line + 1), at_ = i.take(line + 1);
    batch_ = {f.take(both), i.take(both), i.take(room),     i.take(room), f.take(room),
              f.take(room), f.take(room), found.take(room), f.take(room)};
  }

  Track& track() { return track_; }

  /** Cells of the line on track() are inferred, now or with those of a later one. */
  void add_line()
  {
    gather(walk());
    if (count_ >= kEnough) finish();
  }

  /** What is not inferred yet. */
  void finish()
  {
    if (count_ == 0) return;
    for (int c = count_; c % kBlock != 0; c++) copy_cell(c, kSamples, 0);
    const int cells = (count_ + kBlock - 1) / kBlock * kBlock;
    if (!kAlongRays)
      infer_along_axis(k_, batch_, cells, track_.step_m);
    else if (k_.fill_rule == kernels::kFillLines)
      infer_along_rays<true>(k_, batch_, cells);
    else
      infer_along_rays<false>(k_, batch_, cells);
    put();
    count_ = 0;
  }

 private:
  static constexpr int kBoth = 2 * kSamples, kBlock = 16, kEnough = 256;

  /** Lists the line's samples, and its cells that are none. Returns how many cells. */
  int walk()
  {
    const Track t = track_;
    const Met<kSamples> met = met_;
    int *const next = next_, *const at = at_;
    int end = nowhere(0), count = 0;
    for (int p = 0; p < t.places; p++)
    {
      const float height_m = t.height_m[kAlongRays ? t.read[p] : p];
      met.height_m[end] = height_m, met.place[end] = p;
      if (kAlongRays) met.cell[end] = t.cell[p];
      next[count] = end, at[count] = p;
      const bool known = kernels::is_known(height_m);
      end += known;
      count += !known & (!kAlongRays || t.own[p] != 0);
    }
    nowhere(end);
    return count;
  }
  int nowhere(int end) const
  {
    for (int s = 0; s < kSamples; s++)
      met_.height_m[end + s] = 0, met_.place[end + s] = kNowhere, met_.cell[end + s] = 0;
    return end + kSamples;
  }

  /** Adds those cells to the batch that have samples within reach. */
  void gather(int cells)
  {
    const Track t = track_;
    const int reach = reach_of(t.step_m, t.places - 1, k_);
    int count = count_;
    for (int c = 0; c < cells; c++)
    {
      const int next = next_[c], at = at_[c];
      copy_cell(count, next, at);
      const bool near =
          (at - met_.place[next - 1] <= reach) | (kernels::abs_of(at - met_.place[next]) <= reach);
      batch_.to[count] = t.cell[at];
      __builtin_prefetch(to_.cells + t.cell[at], 1);
      if (kAlongRays)
      {
        batch_.step_m[count] = t.step_m;
        batch_.before_m2[count] = variance_m2_[met_.cell[next - 1]];
        batch_.behind_m2[count] = variance_m2_[met_.cell[next]];
        if (!near) put_nothing(next, at);
      }
      count += near;
    }
    count_ = count;
  }
  void copy_cell(int c, int next, int at) const
  {
    std::memcpy(
        batch_.height_m + c * kBoth, met_.height_m + next - kSamples, kBoth * sizeof(float));
    std::memcpy(batch_.place + c * kBoth, met_.place + next - kSamples, kBoth * sizeof(int));
    batch_.at[c] = at;
  }

  /** Fills find nothing; what stage 9 wants is farther. */
  void put_nothing(int next, int at) const
  {
    const Track& t = track_;
    const int far = kernels::places_in(k_.sparsity_search_m, t.step_m, t.places - 1);
    const bool both =
        (at - met_.place[next - 1] <= far) & (kernels::abs_of(at - met_.place[next]) <= far);
    const float across_m = kernels::abs_of(met_.height_m[next - 1] - met_.height_m[next]);
    to_.cells[t.cell[at]] = {};
    to_.across_m[t.cell[at]] = both ? across_m : kernels::kNan;
  }

  static int reach_of(float step_m, int last_place, const kernels::Config& k)
  {
    return kernels::places_in(k.fill_search_m, step_m, last_place);
  }

  template <bool kAlongLines>
  TALUS_CLONES static void infer_along_rays(
      const kernels::Config k, const Batch<kSamples> b, int cells)
  {
    const int rings = kernels::line_rings(k);
    TALUS_INDEPENDENT
    for (int c = 0; c < cells; c++)
    {
      const float step_m = b.step_m[c];
      const int reach = reach_of(step_m, rings, k);
      const int far = kernels::places_in(k.sparsity_search_m, step_m, rings);
      const SideEstimate inner = b.infer(c, -1, step_m, reach, k);
      const SideEstimate outer = b.infer(c, 1, step_m, reach, k);
      b.found[c] = {
          kAlongLines ? kernels::fuse_lines(inner, outer, true, k)
                      : kernels::apply_rule(inner, outer, k),
          kernels::fuse_variances(
              variance(inner, b.before_m2[c], k), variance(outer, b.behind_m2[c], k))};
      b.across_m[c] = kernels::abs_of(b.nearest(c, -1, far) - b.nearest(c, 1, far));
    }
  }

  TALUS_CLONES static void infer_along_axis(
      const kernels::Config k, const Batch<kSamples> b, int cells, float step_m)
  {
    const int reach = reach_of(step_m, k.cells - 1, k);
    TALUS_INDEPENDENT
    for (int c = 0; c < cells; c++)
    {
      const SideEstimate before = b.infer(c, -1, step_m, reach, k);
      b.found[c].lines = kernels::fuse_lines(before, b.infer(c, 1, step_m, reach, k), false, k);
    }
  }

  static float variance(const SideEstimate& side, float of_sample_m2, const kernels::Config& k)
  {
    return kernels::select(
        side.any(), kernels::spread_variance(of_sample_m2, side.distance_m, k), kernels::kNan);
  }

  void put() const
  {
    const Batch<kSamples> b = batch_;
    for (int c = 0; c < count_; c++)
    {
      const kernels::Inference& found = b.found[c];
      kernels::Inference& to = to_.cells[b.to[c]];
      if (!kAlongRays)
        to.lines.add(found.lines);
      else
      {
        to = found;
        if (!found.two_sided()) to_.across_m[b.to[c]] = b.across_m[c];
      }
    }
  }

  const kernels::Config& k_;
  const float* variance_m2_;
  const kernels::InferenceGrid to_;
  Track track_;
  Met<kSamples> met_;
  int *next_, *at_;  //!< by cell to infer: the next sample, the place on the line
  Batch<kSamples> batch_;
  int count_ = 0;
};

/** A line from the sensor's cell to the border: as kernels::line_cell() and line_through(). */
TALUS_CLONES inline void track_ray(const kernels::LineGrid grid, kernels::Line line, Track t)
{
  const int rings = t.places - 1, middle = grid.middle();
  const int along[] = {1, grid.pitch, -1, -grid.pitch}, turned[] = {1, 1, -1, -1};
  const int with_ring = along[line.side], with_minor = along[(line.side + 1) % 4];
  const int read_ring = turned[line.side], read_minor = with_ring * with_minor / read_ring;
  const float inverse = 1.0f / static_cast<float>(2 * rings);
  TALUS_INDEPENDENT
  for (int ring = 0; ring <= rings; ring++)
  {
    const int minor = kernels::floor_div(2 * line.minor * ring + rings, 2 * rings, inverse);
    const int twice = kernels::max_of(2 * ring, 1);
    const int through =
        kernels::floor_div(2 * minor * rings + ring, twice, 1.0f / static_cast<float>(twice));
    t.cell[ring] = middle + ring * with_ring + minor * with_minor;
    t.read[ring] = middle + ring * read_ring + minor * read_minor;
    t.own[ring] = (through == line.minor) & (ring > 0);
  }
}

/** The lines from the sensor, then rows, then columns, in parts that touch different cells. */
struct Walk
{
  const kernels::Config& k;
  kernels::LineGrid grid;
  kernels::Samples samples;
  kernels::InferenceGrid to;

  int parts_of_rays() const { return parts(kernels::line_count(k)); }
  int parts_of_axis() const { return parts(grid.side); }

  void rays(int part) const
  {
    if (k.fill_samples <= kFewSamples)
      search_rays<kFewSamples>(part);
    else
      search_rays<kMaxSamples>(part);
  }
  void rows(int part) const { search_axis(part, samples.height_m, grid.pitch, 1); }
  void columns(int part) const { search_axis(part, samples.turned_m, 1, grid.pitch); }

  /** Of all samples, rows become columns. */
  void turn(int part) const
  {
    const int first = part * kLinesOfPart, last = std::min(first + kLinesOfPart, grid.side);
    for (int y0 = 0; y0 < grid.side; y0 += kLinesOfPart)
      for (int x = first; x < last; x++)
        for (int y = y0; y < std::min(y0 + kLinesOfPart, grid.side); y++)
          samples.turned_m[x * grid.pitch + y] = samples.height_m[y * grid.pitch + x];
  }

 private:
  static int parts(int lines) { return (lines + kLinesOfPart - 1) / kLinesOfPart; }

  template <int kSamples>
  void search_rays(int part) const
  {
    const int rings = kernels::line_rings(k), first = part * kLinesOfPart;
    const int last = std::min(first + kLinesOfPart, kernels::line_count(k));
    LineSearch<kSamples, true> search(k, samples.variance_m2, to, rings + 1);
    Track& track = search.track();
    track.places = rings + 1;
    for (int l = first; l < last; l++)
    {
      const kernels::Line line = kernels::line_from_index(l, rings);
      track.height_m = line.side % 2 ? samples.turned_m : samples.height_m;
      track.step_m = kernels::line_stretch(line, rings) * k.resolution_m;
      track_ray(grid, line, track);
      search.add_line();
    }
    search.finish();
  }

  void search_axis(int part, const float* height_m, int to_next_line, int to_next_place) const
  {
    if (k.fill_samples <= kFewSamples)
      search_axis<kFewSamples>(part, height_m, to_next_line, to_next_place);
    else
      search_axis<kMaxSamples>(part, height_m, to_next_line, to_next_place);
  }
  template <int kSamples>
  void search_axis(int part, const float* height_m, int to_next_line, int to_next_place) const
  {
    const int first = part * kLinesOfPart, last = std::min(first + kLinesOfPart, grid.side);
    LineSearch<kSamples, false> search(k, samples.variance_m2, to, grid.side);
    Track& track = search.track();
    track.places = grid.side;
    track.step_m = k.resolution_m;
    for (int l = first; l < last; l++)
    {
      track.height_m = height_m + l * grid.pitch;
      for (int p = 0; p < grid.side; p++) track.cell[p] = l * to_next_line + p * to_next_place;
      search.add_line();
    }
    search.finish();
  }
};

}  // namespace talus::lines
