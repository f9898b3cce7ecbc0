#include "cpu/lines.h"

#include "kernels/7_sparsity.h"

#include <algorithm>
#include <vector>

namespace talus::lines
{
namespace
{
using kernels::SideEstimate;

constexpr int kNowhere = -(1 << 20);  //!< the index of a sample that was never met
/** Code is compiled for kFewSamples, the default, and for any number up to kMaxSamples. */
constexpr int kFewSamples = 2, kMaxSamples = 16;

std::int32_t bit_of(int lane) { return static_cast<std::int32_t>(1u << lane); }
/** The bits of the lines that know a height. */
std::uint32_t known_of(const float* height_m)
{
  std::int32_t known = 0;
  TALUS_INDEPENDENT
  for (int l = 0; l < kLanes; l++)
    known |= kernels::select(kernels::is_known(height_m[l]), bit_of(l), 0);
  return static_cast<std::uint32_t>(known);
}

/** Memory of this thread, kept from frame to frame. */
template <class T>
T* scratch(int size)
{
  static thread_local std::vector<T> memory;
  if (memory.size() < static_cast<std::size_t>(size)) memory.resize(static_cast<std::size_t>(size));
  return memory.data();
}

/** Where lines are at one index, across the strip, and which of those cells are theirs to infer. */
struct alignas(64) Crossing
{
  int minor[kLanes];
  std::uint32_t own;  //!< a bit for each line
};

struct Strip
{
  int lines, cells;
  int first, along, across;  //!< a line's cell: first + index * along + minor * across
  const Crossing* crossings;  //!< by index; on parallel lines all are the same
  float cell_m[kLanes] = {};  //!< length of a line in each cell
  int fill_cells[kLanes] = {},
      sparsity_cells[kLanes] = {};  //!< cells that fills and stage 7 search
  int reach = 0, far_reach = 0;  //!< max of fill_cells and of sparsity_cells
  int near_robot = 0;  //!< from this index on all are too far for eq. 14

  const Crossing& at(int index, bool parallel) const { return crossings[parallel ? 0 : index]; }
  /** Whether lines are columns, so that the cells of one index are neighbours in memory. */
  bool columns() const { return across == 1 && lines == kLanes; }
  /** Whether lines are rows. */
  bool rows() const { return along == 1; }
  /** Whether they are close together, and those of the next index in another row. */
  bool leaps() const { return across == 1 || across == -1; }
  void measure(int line, float length_m, const kernels::Config& k)
  {
    cell_m[line] = length_m;
    fill_cells[line] = kernels::cells_in(k.fill_search_m, length_m, cells - 1);
    sparsity_cells[line] = kernels::cells_in(k.sparsity_search_m, length_m, cells - 1);
    reach = std::max(reach, fill_cells[line]);
    far_reach = std::max(far_reach, sparsity_cells[line]);
    near_robot =
        std::max(near_robot, kernels::cells_in(k.sparsity_range_m, length_m, cells - 1) + 1);
  }
};

/** The last samples that the lines met, the nearest first. */
template <int kSamples>
struct alignas(64) Met
{
  float height_m[kSamples][kLanes];
  int index[kSamples][kLanes];
  int latest;  //!< the index of the nearest of all lines ...
  std::uint32_t latest_lines;  //!< ... and which lines met it there

  static Met nothing()
  {
    Met met{};
    for (auto& sample : met.index) std::fill_n(sample, kLanes, kNowhere);
    met.latest = kNowhere;
    return met;
  }

  /** Whether a line met a sample within a distance. */
  bool is_within(int cells, int here) const { return kernels::abs_of(here - latest) <= cells; }

  /** Sets line `l` to the samples met `before`, and to the one `here` if it is known. */
  void meet(const Met& before, int l, bool known, float sample_m, int here)
  {
    for (int s = kSamples - 1; s > 0; s--)
    {
      height_m[s][l] = kernels::select(known, before.height_m[s - 1][l], before.height_m[s][l]);
      index[s][l] = kernels::select(known, before.index[s - 1][l], before.index[s][l]);
    }
    height_m[0][l] = kernels::select(known, sample_m, before.height_m[0][l]);
    index[0][l] = kernels::select(known, here, before.index[0][l]);
  }

  int distance(int l, int here) const { return kernels::abs_of(here - index[0][l]); }

  /** Of a side of which no line has a sample near by. */
  SideEstimate infer_far(int l, int here, const Strip& strip) const
  {
    const float away_m = static_cast<float>(distance(l, here)) * strip.cell_m[l];
    return kernels::SideSum().estimate(nearest_m(l), 0, away_m);
  }
  SideEstimate infer(int l, int here, const Strip& strip, const kernels::Config& k) const
  {
    kernels::SideSum sum;
    float away_m[kSamples];
    bool inside[kSamples];
    for (int s = 0; s < kSamples; s++)
    {
      const int cells = kernels::abs_of(here - index[s][l]);
      inside[s] = (cells <= strip.fill_cells[l]) & (s == 0 || s < k.fill_samples);
      away_m[s] = static_cast<float>(cells) * strip.cell_m[l];
      sum.add(height_m[s][l], kernels::select(inside[s], away_m[s], kernels::kOutOfReach_m), k);
    }
    return sum.estimate(nearest_m(l), kernels::select(inside[0], distance(l, here), 0), away_m[0]);
  }

 private:
  float nearest_m(int l) const
  {
    return kernels::select(index[0][l] != kNowhere, height_m[0][l], kernels::kNan);
  }
};

/** The nearest index behind the last sample where kernels::ends_below_ground(). */
struct alignas(64) DropAhead
{
  int index[kLanes];

  DropAhead() { std::fill_n(index, kLanes, -kNowhere); }
};

using LinesFound = SideBySide<kernels::LineFusion, kLanes>;

/** The inferred values at one index. */
struct Found
{
  LinesFound lines;
  float fall_m[kLanes];
  std::int32_t marks[kLanes];
};

/** What rows found at kLanes indices, to be added row by row, where cells are neighbours. */
struct RowsFound
{
  SideBySide<kernels::LineFusion, kLanes * kLanes> lines;  //!< by index, then by line
  int first;  //!< index
  std::uint32_t set = 0;  //!< a bit for each index

  void put(int index, const LinesFound& found)
  {
    put_at(index - first, [&found](int l) { return found.load(l); });
    set |= static_cast<std::uint32_t>(bit_of(index - first));
  }
  /** Sets indices where nothing was found. */
  void complete()
  {
    for (int p = 0; set && p < kLanes; p++)
      if (!(set & static_cast<std::uint32_t>(bit_of(p))))
        put_at(p, [](int) { return kernels::LineFusion{}; });
  }

 private:
  template <class Value>
  void put_at(int index, const Value& value)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++) lines.store(index * kLanes + l, value(l));
  }
};

/** `kRays`: lines from the sensor; else rows or columns. */
template <int kSamples, bool kRays>
class Sweep
{
  using Side = Met<kSamples>;
  static constexpr int kAhead = 16;  //!< cells that are fetched early

 public:
  TALUS_CLONES static void run(const Walk& walk, const Strip& lines, Side* met)
  {
    // Copies that nothing else can write to, so that loops need not read them again. Passing values
    // would make gcc with -fschedule-insns write them to the stack before it has room, where a
    // signal may overwrite them.
    const kernels::Map m = walk.m;
    const Strip strip = lines;
    const Side* before = outwards(strip, m, met);
    Side behind = Side::nothing();
    DropAhead drop;
    RowsFound rows;
    rows.first = strip.cells - kLanes;
    for (int index = strip.cells - 1; index >= 0; index--)
    {
      if (!kRays && index < rows.first) add(strip, rows, m);
      // Farther away it does not matter, see infer().
      if (kRays && index % kernels::kDropStride_cells == 0 &&
          before->is_within(2 * strip.reach, index))
        find_drops(strip, m, *before, index, drop);
      const bool met_here = before->latest == index;
      const std::uint32_t own = strip.at(index, !kRays).own;
      const std::uint32_t wanted = met_here ? own & ~before->latest_lines : own;
      if (wanted) infer(m, strip, *before, behind, drop, wanted, index, rows);
      if (met_here) turn(*before--, index, behind, drop);
    }
    if (!kRays) add(strip, rows, m);
  }

 private:
  /** Lists the samples that the lines met, anew at each index with one. Returns the last. */
  static Side* outwards(const Strip& strip, const kernels::Map& m, Side* met)
  {
    *met = Side::nothing();
    for (int index = 0; index < strip.cells; index++)
    {
      const int first = strip.first + index * strip.along;
      const int* const minor = strip.at(index, !kRays).minor;
      if (strip.leaps())
        fetch(strip, m.sample_m, std::min(index + kAhead, strip.cells - 1), kLanes - 1);
      float height_m[kLanes];
      if (!kRays && strip.columns())
        std::copy_n(m.sample_m + first, kLanes, height_m);
      else
      {
        TALUS_INDEPENDENT
        for (int l = 0; l < kLanes; l++) height_m[l] = m.sample_m[first + minor[l] * strip.across];
      }
      const std::uint32_t known = known_of(height_m);
      if (!known) continue;
      const Side& before = *met++;
      TALUS_INDEPENDENT
      for (int l = 0; l < kLanes; l++)
        met->meet(before, l, kernels::is_known(height_m[l]), height_m[l], index);
      met->latest = index, met->latest_lines = known;
    }
    return met;
  }

  /** The samples met `here` lie behind from now on. */
  static void turn(const Side& here, int index, Side& behind, DropAhead& drop)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      const bool known = here.index[0][l] == index;
      behind.meet(behind, l, known, here.height_m[0][l], index);
      if (kRays) drop.index[l] = kernels::select(known, -kNowhere, drop.index[l]);
    }
    behind.latest = index;
  }

  static void find_drops(
      const Strip& strip, const kernels::Map& m, const Side& here, int index, DropAhead& drop)
  {
    const int first = strip.first + index * strip.along;
    const int* const minor = strip.at(index, false).minor;
    if (strip.leaps() || index % kLanes == 0)
      fetch(strip, m.ends_m, std::max(index - kAhead, 0), strip.leaps() ? kLanes - 1 : 1);
    std::int32_t under = 0;
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      const float ends_m = m.ends_m[first + minor[l] * strip.across];
      const bool below = (here.index[0][l] >= 0) & (here.index[0][l] < index) &
                         kernels::ends_below_ground(
                             ends_m, here.height_m[0][l],
                             static_cast<float>(here.distance(l, index)) * strip.cell_m[l]);
      under |= kernels::select(below, bit_of(l), 0);
    }
    for (auto lines = static_cast<std::uint32_t>(under); lines; lines &= lines - 1)
    {
      const int l = __builtin_ctz(lines);
      if (!kernels::is_passed_over(
              m.free_above_m + first, strip.across, minor[l], strip.cells - 1, here.height_m[0][l]))
        drop.index[l] = index;
    }
  }

  /** Fetches the values at an index of each stride-th line, which processors cannot predict. */
  TALUS_FETCHES static void fetch(const Strip& strip, const float* values, int index, int stride)
  {
    const float* const at = values + strip.first + index * strip.along;
    const int* const minor = strip.at(index, !kRays).minor;
    for (int l = 0; l < kLanes; l += stride) __builtin_prefetch(at + minor[l] * strip.across);
  }

  static void infer(
      const kernels::Map& m, const Strip& strip, const Side& before, const Side& behind,
      const DropAhead& drop, std::uint32_t wanted, int index, RowsFound& rows)
  {
    const kernels::Config& k = m.k;
    const bool has_before = before.is_within(strip.reach, index),
               has_behind = behind.is_within(strip.reach, index),
               near_robot = kRays && index <= strip.near_robot;
    Found found;
    if (has_before && has_behind)
      infer<kNear, kNear>(k, strip, before, behind, drop, index, found);
    else if (has_before)
      infer<kNear, kFar>(k, strip, before, behind, drop, index, found);
    else if (has_behind)
      infer<kFar, kNear>(k, strip, before, behind, drop, index, found);
    else
    {
      if (near_robot) forget_fall(strip, wanted, index, m);
      return;
    }
    if (near_robot && before.is_within(strip.far_reach, index) &&
        behind.is_within(strip.far_reach, index))
      find_falls(k, strip, before, behind, index, found);
    else if (near_robot)
      std::fill_n(found.fall_m, kLanes, kernels::kNan);
    if (kRays)
      put(strip, found, wanted, index, m);
    else if (strip.rows())
      rows.put(index, found.lines);
    else
      add(strip, found.lines, index, m);
  }

  /** Whether any line has a sample near by on a side. */
  enum Nearness
  {
    kFar,
    kNear
  };
  template <Nearness kBefore, Nearness kBehind>
  static void infer(
      const kernels::Config& k, const Strip& strip, const Side& before, const Side& behind,
      const DropAhead& drop, int index, Found& found)
  {
    SideBySide<SideEstimate, kLanes> inner, outer;
    infer_side<kBefore>(k, strip, before, index, inner);
    infer_side<kBehind>(k, strip, behind, index, outer);
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      const SideEstimate a = inner.load(l), b = outer.load(l);
      found.lines.store(l, kernels::fuse_sides(a, b));
      if (kRays)
      {
        const bool drop_ahead = (drop.index[l] - index <= strip.fill_cells[l]) &
                                (behind.distance(l, index) > strip.sparsity_cells[l]);
        found.marks[l] = kernels::marks_of_sides(a, b, drop_ahead);
      }
    }
  }

  template <Nearness kThere>
  static void infer_side(
      const kernels::Config& k, const Strip& strip, const Side& side, int index,
      SideBySide<SideEstimate, kLanes>& to)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
      to.store(
          l, kThere == kNear ? side.infer(l, index, strip, k) : side.infer_far(l, index, strip));
  }

  /** Between the samples on both sides; unknown if one is too far for stage 7. */
  static kernels::Gap gap(
      const Strip& strip, const Side& before, const Side& behind, int l, int index)
  {
    const bool both = (before.distance(l, index) <= strip.sparsity_cells[l]) &
                      (behind.distance(l, index) <= strip.sparsity_cells[l]);
    const auto length_m = [&](int from, int to)
    { return static_cast<float>(kernels::abs_of(to - from)) * strip.cell_m[l]; };
    return {
        length_m(before.index[0][l], behind.index[0][l]),
        kernels::select(both, before.height_m[0][l], kernels::kNan), behind.height_m[0][l],
        behind.height_m[1][l], length_m(behind.index[0][l], behind.index[1][l])};
  }

  static void find_falls(
      const kernels::Config& k, const Strip& strip, const Side& before, const Side& behind,
      int index, Found& found)
  {
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      const float robot_m = static_cast<float>(index) * strip.cell_m[l];
      found.fall_m[l] =
          kernels::estimate_fall(gap(strip, before, behind, l, index), robot_m, found.marks[l], k);
    }
  }

  static void put(
      const Strip& strip, const Found& found, std::uint32_t wanted, int index,
      const kernels::Map& m)
  {
    const InferenceGrid to{m};
    const int* const minor = strip.at(index, false).minor;
    const int first = strip.first + index * strip.along;
    const bool near_robot = index <= strip.near_robot;
    fetch(strip, minor, index, to);
    for (; wanted; wanted &= wanted - 1)
    {
      const int l = __builtin_ctz(wanted), i = first + minor[l] * strip.across;
      to.set(i, found.lines.load(l));
      m.fill_marks[i] = static_cast<std::uint16_t>(found.marks[l]);
      if (near_robot) m.fall_m[i] = found.fall_m[l];
    }
  }
  /** Fetches the cells of an earlier index; in rows those that share a cache line. */
  TALUS_FETCHES static void fetch(
      const Strip& strip, const int* minor, int index, const InferenceGrid& to)
  {
    const int stride = strip.leaps() ? kLanes - 1 : index % kLanes == 0 ? 1 : kLanes;
    const int ahead = strip.leaps() ? kAhead / 2 : kAhead;
    const int first = strip.first + (index - ahead) * strip.along;
    if (stride < kLanes)
      for (int l = 0; l < kLanes; l += stride) to.fetch(first + minor[l] * strip.across);
  }
  static void forget_fall(
      const Strip& strip, std::uint32_t wanted, int index, const kernels::Map& m)
  {
    const int* const minor = strip.at(index, false).minor;
    const int first = strip.first + index * strip.along;
    for (; wanted; wanted &= wanted - 1)
      m.fall_m[first + minor[__builtin_ctz(wanted)] * strip.across] = kernels::kNan;
  }

  /** Adds what columns found at an index, where cells are neighbours. */
  static void add(const Strip& strip, const LinesFound& found, int index, const kernels::Map& m)
  {
    const InferenceGrid to{m};
    const int first = strip.first + index * strip.along;
    for (const int l : {0, kLanes - 1}) to.fetch_lines(first - kAhead / 2 * strip.along + l);
    add_neighbours(0, strip.lines, to, first, [&found](int l) { return found.load(l); });
  }
  /** Adds what rows found, and goes on to the indices before. */
  static void add(const Strip& strip, RowsFound& rows, const kernels::Map& m)
  {
    const InferenceGrid to{m};
    rows.complete();
    int at[kLanes];  // in an array, so that compilers gather
    for (int p = 0; p < kLanes; p++) at[p] = p * kLanes;
    for (int l = 0; rows.set && l < strip.lines; l++)
    {
      const int first = strip.first + l * strip.across + rows.first;
      to.fetch_lines(first - kLanes);
      add_neighbours(
          std::max(-rows.first, 0), kLanes, to, first,
          [&](int p) { return rows.lines.load(at[p] + l); });
    }
    rows.first -= kLanes;
    rows.set = 0;
  }
  /** Adds value(i) to the cell `first` + i for i in [begin, end). */
  template <class Value>
  static void add_neighbours(
      int begin, int end, const InferenceGrid& to, int first, const Value& value)
  {
    if (end - begin == kLanes)
    {
      TALUS_INDEPENDENT
      for (int i = 0; i < kLanes; i++) to.add(first + i, value(i));
    }
    else
      for (int i = begin; i < end; i++) to.add(first + i, value(i));
  }
};

/** The lines of kernels::line_through(). */
TALUS_CLONES void cross(int rings, int first, Crossing* crossings)
{
  for (int ring = 0; ring <= rings; ring++)
  {
    std::int32_t owns = 0;
    TALUS_INDEPENDENT
    for (int l = 0; l < kLanes; l++)
    {
      const int line = std::min(first + l, rings - 1);
      const float inverse = 1.0f / static_cast<float>(2 * rings);
      const int minor = kernels::line_aside(line, ring, rings, inverse);
      const int twice = std::max(2 * ring, 1);
      const int through =
          kernels::floor_div(2 * minor * rings + ring, twice, 1.0f / static_cast<float>(twice));
      crossings[ring].minor[l] = minor;
      const bool own = (through == line) & (line == first + l) & (ring > 0);
      owns |= kernels::select(own, bit_of(l), 0);
    }
    crossings[ring].own = static_cast<std::uint32_t>(owns);
  }
}
/** The lines from the sensor, valid until this thread asks for others. */
const Crossing* crossings_of(int rings, int first)
{
  static thread_local int last_rings = 0, last_first = 0;
  Crossing* const crossings = scratch<Crossing>(rings + 1);
  if (rings != last_rings || first != last_first) cross(rings, first, crossings);
  last_rings = rings, last_first = first;
  return crossings;
}

template <int kSamples, bool kRays>
void sweep(const Walk& walk, const Strip& strip)
{
  Sweep<kSamples, kRays>::run(walk, strip, scratch<Met<kSamples>>(strip.cells + 1));
}
template <bool kRays>
void sweep(const Walk& walk, const Strip& strip)
{
  if (walk.m.k.fill_samples <= kFewSamples)
    sweep<kFewSamples, kRays>(walk, strip);
  else
    sweep<kMaxSamples, kRays>(walk, strip);
}

void sweep_axis(const Walk& walk, int part, int along, int across)
{
  const kernels::Config& k = walk.m.k;
  const int first = walk.first_of(part), lines = walk.first_of(part + 1) - first;
  Crossing parallel;
  for (int l = 0; l < kLanes; l++) parallel.minor[l] = std::min(l, lines - 1);
  parallel.own = (1u << lines) - 1;
  Strip strip{lines, k.cells, first * across, along, across, &parallel};
  for (int l = 0; l < kLanes; l++) strip.measure(l, k.resolution_m, k);
  sweep<false>(walk, strip);
}
}  // namespace

void Walk::rays(int part) const
{
  const kernels::Config& k = m.k;
  const int rings = m.lines.half, first = part / 4 * kLanes - rings, side = part % 4;
  const int along[] = {1, m.lines.pitch, -1, -m.lines.pitch};
  Strip strip{
      kLanes,
      rings + 1,
      m.lines.middle(),
      along[side],
      along[(side + 1) % 4],
      crossings_of(rings, first)};
  for (int l = 0; l < kLanes; l++)
  {
    const kernels::Line line{side, std::min(first + l, rings - 1)};
    strip.measure(l, kernels::line_stretch(line, rings) * k.resolution_m, k);
  }
  sweep<true>(*this, strip);
}
void Walk::rows(int part) const { sweep_axis(*this, part, 1, m.lines.pitch); }
void Walk::columns(int part) const { sweep_axis(*this, part, m.lines.pitch, 1); }

}  // namespace talus::lines
