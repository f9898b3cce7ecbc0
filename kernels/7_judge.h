#pragma once
#include "kernels/7_sparsity.h"
#include "kernels/7_traversability.h"
#include "kernels/map.h"

#include <initializer_list>

namespace talus::kernels
{
/** The Passability of a cell, at `at`, and of its neighbours. Rows are `pitch` apart. */
struct PassabilityAround
{
  const std::uint8_t* at;
  int pitch;

  TALUS_HD bool blocks(int to) const { return at[to] == kImpassable; }
  TALUS_HD bool is_settled(int to) const { return at[to] != kPassable; }
};

/** Stage 7 on cell (ix, iy), along rows and then along columns. `kWithFeatureLayers`: slope, step,
 * roughness and sparsity are wanted, too. */
template <bool kWithFeatureLayers>
struct ComputeFeatures
{
  using Row = RowSums;
  using Window = Moments;
  static constexpr bool kHasPlain = true;
  const Map& m;

  TALUS_HD const Surface& neighbour(int ix, int iy) const
  {
    return m.judged_surface[m.surface_at(ix, iy)];
  }
  TALUS_HD void add(RowSums& sums, int ix, int iy, int d) const
  {
    sums.add(neighbour(ix + d, iy), d);
  }
  TALUS_HD void add(Moments& sums, const RowSums& row, int d) const { sums.add(row, d); }

  TALUS_HD void operator()(int ix, int iy, const Moments& sums) const
  {
    put(ix, iy, judge_most<false>(ix, iy, sums, true));
  }
  /** Whether operator() does more for a cell than write_unjudged(). */
  TALUS_HD bool needs_features(int ix, int iy) const
  {
    const Surface& cell = neighbour(ix, iy);
    return kWithFeatureLayers ? cell.known()
                              : cell.is(kSurfaceSeen);  // of unknown cells no flag is set
  }
  TALUS_HD void write_unjudged(int ix, int iy) const
  {
    if constexpr (kWithFeatureLayers)
      for (float* const part : {m.out.slope, m.out.step, m.out.roughness, m.out.sparsity})
        part[m.window_at(ix, iy)] = kNan;
    put(ix, iy, {kNan, kPassable});
  }
  /** Whether plain(), which is faster, gives the same result. */
  TALUS_HD bool is_plain(const Moments& sums) const { return is_whole(sums, m.k); }
  TALUS_HD void plain(int ix, int iy, const Moments& sums) const
  {
    put(ix, iy, judge_most<true>(ix, iy, sums, true));
  }
  /** Whether finish() may change the result of operator() or plain(). */
  TALUS_HD bool applies(int ix, int iy, const Moments&) const
  {
    return neighbour(ix, iy).is(kSurfacePossibleDropOff) |
           (m.passability[m.window_at(ix, iy)] == kSteep);
  }
  /** Handles steep cells and cells that may drop, which are few. */
  TALUS_HD void finish(int ix, int iy, const Moments&) const
  {
    const int window_i = m.window_at(ix, iy);
    const Judgement before{m.out.traversability[window_i], m.passability[window_i]};
    put(ix, iy, settle(ix, iy, before, true));
  }
  /** Does all of that and returns it. Feature layers are stored for the caller's `own` cells. */
  TALUS_HD Judgement judge(int ix, int iy, const Moments& sums, bool own) const
  {
    return settle(ix, iy, judge_most<false>(ix, iy, sums, own), own);
  }

 private:
  TALUS_HD void put(int ix, int iy, const Judgement& j) const
  {
    const int window_i = m.window_at(ix, iy);
    m.out.traversability[window_i] = j.score;
    m.passability[window_i] = static_cast<std::uint8_t>(j.passability);
  }
  /** Judges a cell without LowStep and drops. */
  template <bool kWhole>
  TALUS_HD Judgement judge_most(int ix, int iy, const Moments& sums, bool own) const
  {
    const Surface& cell = m.judged_surface[m.surface_at(ix, iy)];
    const bool known = cell.known();
    const Features f = features_of<kWhole>(sums, cell.height(), m.k);
    if constexpr (kWithFeatureLayers)
      if (own)
      {
        const int window_i = m.window_at(ix, iy);
        m.out.slope[window_i] = select(known, f.slope, kNan);
        m.out.step[window_i] = select(known, f.step, kNan);
        m.out.roughness[window_i] = select(known, f.roughness, kNan);
        m.out.sparsity[window_i] = kNan;
      }
    // If no ray hit a cell or passed low over it, it may be the inside of an object.
    const bool judged = known & cell.is(kSurfaceSeen);
    const Judgement features = fuse_features(f, m.k);
    const bool driven = cell.is(kSurfaceDriven), steep = features.passability == kSteep;
    const float min_score = select(driven, kDrivenScore, 0.0f);
    const float max_score = select(steep & driven, kDrivenScore, kInfinity);
    const float score = max_of(min_of(features.score, max_score), min_score);
    const int of_low = select(steep & !driven, kSteep, kPassable);
    const int of_judged = select(score == 0.0f, kImpassable, of_low);
    return {select(judged, score, kNan), select(judged, of_judged, static_cast<int>(kPassable))};
  }
  /** Makes cells that may drop, and steep cells at no low step, impassable. */
  TALUS_HD Judgement settle(int ix, int iy, const Judgement& before, bool own) const
  {
    const Judgement impassable{0.0f, kImpassable};
    if (neighbour(ix, iy).is(kSurfacePossibleDropOff))
    {
      if constexpr (kWithFeatureLayers)
        if (own) m.out.sparsity[m.window_at(ix, iy)] = drop_off_score(ix, iy);
      return impassable;
    }
    const bool steep = before.passability == kSteep && !LowStep{m}.is_at(ix, iy);
    return steep ? impassable : before;
  }
  /** Whether eq. 14 applies. The sensor's own cell lies on no line. */
  TALUS_HD bool is_near(int ix, int iy) const
  {
    const bool on_line = ix != m.k.cells / 2 || iy != m.k.cells / 2;
    return on_line && robot_m(ix, iy) <= m.k.sparsity_range_m;
  }
  /** Eq. 14; 0 where the drop is only remembered. */
  TALUS_HD float drop_off_score(int ix, int iy) const
  {
    if (!is_near(ix, iy)) return 0.0f;
    const float score = sparsity(m.fall_m[m.lines.at(ix, iy)], robot_m(ix, iy), m.k);
    return select(score < kSparse, score, 0.0f);
  }
  TALUS_HD float robot_m(int ix, int iy) const
  {
    return distance_along_line(ix - m.k.cells / 2, iy - m.k.cells / 2, m.k);
  }
};

/** Keeps for the next frame's stage 4 whether a cell is passable; a guess must be nearly level. */
struct NotePassable
{
  const Map& m;

  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    note(i, m.out.traversability[m.window_at(ix, iy)]);
  }
  TALUS_HD void note(int i, float score) const
  {
    const int others = m.cell.flags[i] & ~kWasPassable;
    const bool guess = m.cell.state[i] == kFilledOneSided;
    const bool leads_on = score >= select(guess, kGuessScore, kEdgeScore);
    m.cell.flags[i] = static_cast<std::uint8_t>(others | select(leads_on, kWasPassable, 0));
  }
};

/** The end of stage 7: an obstacle goes on beside an impassable cell where the score is low,
 * and between two such cells, since no robot fits through one cell. Features end before the edge of
 * a steep face, and of porous objects only some cells are hit. Low steps stay passable. */
struct CompleteObstacles
{
  const Map& m;

  TALUS_HD bool applies(int ix, int iy, int) const { return may_join(ix, iy, around(ix, iy)); }
  TALUS_HD void operator()(int ix, int iy, int) const
  {
    float& score = m.out.traversability[m.window_at(ix, iy)];
    if (joins(ix, iy, around(ix, iy), score)) score = 0.0f;
  }
  /** Stores the joined cell, or `score`. */
  TALUS_HD void complete(int ix, int iy, const PassabilityAround& at, float score) const
  {
    if (may_join(ix, iy, at) && joins(ix, iy, at, score)) score = 0.0f;
    m.out.traversability[m.window_at(ix, iy)] = score;
    if (m.keeps) NotePassable{m}.note(m.at(ix, iy), score);
  }

 private:
  TALUS_HD PassabilityAround around(int ix, int iy) const
  {
    return {m.passability + m.window_at(ix, iy), m.k.cells};
  }
  TALUS_HD bool may_join(int ix, int iy, const PassabilityAround& at) const
  {
    const int n = m.k.cells;
    const bool inside = (ix > 0) & (iy > 0) & (ix < n - 1) & (iy < n - 1);
    return inside & !at.is_settled(0) &
           (settled_in_row(at, -at.pitch) | settled_in_row(at, 0) | settled_in_row(at, at.pitch));
  }
  TALUS_HD bool joins(int ix, int iy, const PassabilityAround& at, float score) const
  {
    const Surface& cell = m.judged_surface[m.surface_at(ix, iy)];
    if (cell.is(kSurfaceDriven)) return false;
    const bool edge = score < kEdgeScore && beside(at);  // false where it is not judged
    return (on(kObstaclesGoOn, m.k) && (edge || between(at))) || beside_drop(ix, iy);
  }
  /** A neighbour of a drop joins it, since the edge is not known to a cell. */
  TALUS_HD bool beside_drop(int ix, int iy) const
  {
    const Surface* at = m.judged_surface + m.surface_at(ix, iy);
    bool any = false;
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++)
        any |= at[dy * m.surface_pitch() + dx].is(kSurfacePossibleDropOff);
    return any;
  }

  static TALUS_HD bool settled_in_row(const PassabilityAround& at, int row)
  {
    return at.is_settled(row - 1) | at.is_settled(row) | at.is_settled(row + 1);
  }

  static TALUS_HD bool beside(const PassabilityAround& at)
  {
    return at.blocks(-1) || at.blocks(1) || at.blocks(-at.pitch) || at.blocks(at.pitch);
  }

  static TALUS_HD bool between(const PassabilityAround& at)
  {
    const auto both = [&at](int to) { return at.blocks(-to) && at.blocks(to); };
    return both(1) || both(at.pitch) || both(at.pitch + 1) || both(at.pitch - 1);
  }
};

}  // namespace talus::kernels
