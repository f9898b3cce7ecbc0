#pragma once
#include "kernels/8_traversability.h"
#include "kernels/9_sparsity.h"

namespace talus::kernels
{
// Stages 8 and 9 on the cells, and what follows from their neighbours.

/** The layers of stages 8 and 9, window order. The first four may be null for those who want
 * traversability alone. */
struct FeatureLayers
{
  float *slope, *step, *roughness, *sparsity, *traversability;
  float* judged;  //!< traversability before CompleteObstacles, with a minus at low steps

  TALUS_HD void put_traversability(int window_i, float value) const
  {
    judged[window_i] = value;
    traversability[window_i] = abs_of(value);
  }
};

/** Stages 8 and 9 on cell (ix, iy): first along rows, then across them. `kParts`: what
 * traversability is made of is wanted too, not it alone. */
template <bool kParts>
struct ComputeFeatures
{
  using Row = RowSums;
  using Window = Moments;
  static constexpr bool kHasPlain = true;
  int cells;
  const Config* config;
  Surfaces surfaces;
  LineGrid grid;
  const float* fall_m;
  FeatureLayers out;

  TALUS_HD const Surface& neighbour(int ix, int iy) const
  {
    return surfaces.cell[surfaces.at(ix, iy)];
  }
  /** Adds the neighbour at distance d in the cell's row. */
  TALUS_HD void add(RowSums& sums, int ix, int iy, int d) const
  {
    sums.add(neighbour(ix + d, iy), d);
  }
  /** Adds the row at distance d. */
  TALUS_HD void add(Moments& sums, const RowSums& row, int d) const { sums.add(row, d); }

  TALUS_HD void operator()(int ix, int iy, const Moments& m) const
  {
    out.put_traversability(iy * cells + ix, judge_most<false>(ix, iy, m, true));
  }
  /** Whether plain() does the same, in less time. */
  TALUS_HD bool is_plain(const Moments& m) const { return is_whole(m, *config); }
  TALUS_HD void plain(int ix, int iy, const Moments& m) const
  {
    out.put_traversability(iy * cells + ix, judge_most<true>(ix, iy, m, true));
  }
  /** Whether finish() may change the cell, after one of these. */
  TALUS_HD bool applies(int ix, int iy, const Moments&) const
  {
    return neighbour(ix, iy).is(kSurfaceMayDrop) | (out.judged[iy * cells + ix] < 0.0f);
  }
  /** What only few cells need. */
  TALUS_HD void finish(int ix, int iy, const Moments&) const
  {
    const int window_i = iy * cells + ix;
    out.put_traversability(window_i, settle(ix, iy, out.judged[window_i], true));
  }
  /** All of that, for executors that go on with the result: returns the traversability before
   * CompleteObstacles, and puts only the parts, of cells that are the caller's `own`. */
  TALUS_HD float judge(int ix, int iy, const Moments& m, bool own) const
  {
    return settle(ix, iy, judge_most<false>(ix, iy, m, own), own);
  }

 private:
  /** As most cells are judged. */
  template <bool kWhole>
  TALUS_HD float judge_most(int ix, int iy, const Moments& m, bool own) const
  {
    const Surface& cell = surfaces.cell[surfaces.at(ix, iy)];
    const bool known = cell.known();
    const Features f = features_of<kWhole>(m, cell.height(), *config);
    if constexpr (kParts)
      if (own)
      {
        const int window_i = iy * cells + ix;
        out.slope[window_i] = select(known, f.slope, kNan);
        out.step[window_i] = select(known, f.step, kNan);
        out.roughness[window_i] = select(known, f.roughness, kNan);
        out.sparsity[window_i] = kNan;
      }
    // What no ray ever met, nor passed low over its ground, may be the inside of a thing.
    const bool seen = cell.is(kSurfaceSeen), judged = known & (seen | cell.is(kSurfaceNear));
    const float features = fuse_features(f, *config);
    const float score = select(seen, features, min_of(features, kPassedNearScore));
    const float driven = max_of(score, kDrivenScore);
    return select(judged, select(cell.is(kSurfaceDriven), driven, score), kNan);
  }
  /** `judged`, unless stage 9 says otherwise, or it is the slope of a low step alone. */
  TALUS_HD float settle(int ix, int iy, float judged, bool own) const
  {
    if (neighbour(ix, iy).is(kSurfaceMayDrop))
    {
      judged = 0.0f;
      if constexpr (kParts)
        if (own) out.sparsity[iy * cells + ix] = suspicion_of(ix, iy);
    }
    return judged < 0.0f && !LowStep{*config, surfaces}.is_at(ix, iy) ? 0.0f : judged;
  }
  /** Whether stage 9 looks there. The sensor's own cell lies on no line. */
  TALUS_HD bool is_near(int ix, int iy) const
  {
    const bool on_line = ix != cells / 2 || iy != cells / 2;
    return on_line && robot_m(ix, iy) <= config->sparsity_range_m;
  }
  /** 0 where it is remembered only. */
  TALUS_HD float suspicion_of(int ix, int iy) const
  {
    if (!is_near(ix, iy)) return 0.0f;
    const float told = sparsity(fall_m[grid.at(ix, iy)], robot_m(ix, iy), *config);
    return select(told < kSparse, told, 0.0f);
  }
  TALUS_HD float robot_m(int ix, int iy) const
  {
    return distance_along_line(ix - cells / 2, iy - cells / 2, *config);
  }
};

/** The last step of stage 8: cells at the edge of what is impassable join it, but for those at a
 * low step. What a neighbourhood says of its middle ends before the edge of what is steep, things
 * that rays pass through are hit in some of their cells only, and what covers a cell in part is hit
 * now and then. */
struct CompleteObstacles
{
  int cells;
  const Config* config;
  Surfaces surfaces;
  const float* judged;  //!< window order, with a row and a cell more on both ends
  float* traversability;

  TALUS_HD bool applies(int ix, int iy, int) const
  {
    return applies(ix, iy, judged + iy * cells + ix, cells);
  }
  TALUS_HD void operator()(int ix, int iy, int) const
  {
    const int window_i = iy * cells + ix;
    if (joins(ix, iy, judged + window_i, cells)) traversability[window_i] = 0.0f;
  }
  /** Joins the cell or puts its judgement, where that lies elsewhere: that of the cell is at `at`,
   * its neighbour's in the next row `pitch` behind it. */
  TALUS_HD void complete(int ix, int iy, const float* at, int pitch) const
  {
    const bool joined = applies(ix, iy, at, pitch) && joins(ix, iy, at, pitch);
    traversability[iy * cells + ix] = joined ? 0.0f : abs_of(*at);
  }

 private:
  TALUS_HD bool applies(int ix, int iy, const float* at, int pitch) const
  {
    const int n = cells;
    const bool inside = (ix > 0) & (iy > 0) & (ix < n - 1) & (iy < n - 1);
    return inside & !is_settled(at) & (around(at - pitch) | around(at) | around(at + pitch));
  }
  TALUS_HD bool joins(int ix, int iy, const float* at, int pitch) const
  {
    const Surface& cell = surfaces.cell[surfaces.at(ix, iy)];
    if (cell.is(kSurfaceDriven)) return false;
    const bool traced = cell.is(kSurfaceTraced);
    return between(at, pitch) || (traced && beside(at, pitch)) || beside_drop(ix, iy) ||
           (is_known(*at) && at_steep_edge(ix, iy, at, pitch));
  }
  /** Nobody knows to a cell where the ground ends. */
  TALUS_HD bool beside_drop(int ix, int iy) const
  {
    const Surface* at = surfaces.cell + surfaces.at(ix, iy);
    bool any = false;
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++) any |= at[dy * surfaces.pitch + dx].is(kSurfaceMayDrop);
    return any;
  }

  static TALUS_HD bool blocks(const float* at) { return *at == 0.0f; }
  /** Impassable already, or at a low step. */
  static TALUS_HD bool is_settled(const float* at) { return *at <= 0.0f; }
  static TALUS_HD bool around(const float* at)
  {
    return is_settled(at - 1) | is_settled(at) | is_settled(at + 1);
  }

  /** Shares a side with an impassable cell. */
  static TALUS_HD bool beside(const float* at, int pitch)
  {
    return blocks(at - 1) || blocks(at + 1) || blocks(at - pitch) || blocks(at + pitch);
  }

  /** Between two impassable cells on opposite sides: no robot fits through one cell. */
  static TALUS_HD bool between(const float* at, int pitch)
  {
    const auto both = [at](int to) { return blocks(at - to) && blocks(at + to); };
    return both(1) || both(pitch) || both(pitch + 1) || both(pitch - 1);
  }

  /** Of measured cells: the surface rises or falls at least a third as steeply as it may to an
   * impassable neighbour on which nothing stands (two cells alone tell a slope that badly), or a
   * face begins in the cell that is higher, with the neighbours, than a step. */
  TALUS_HD bool at_steep_edge(int ix, int iy, const float* judgement, int pitch) const
  {
    const Surface* at = surfaces.cell + surfaces.at(ix, iy);
    if (!at->is(kSurfaceMeasured)) return false;
    const float step = config->step_threshold_m * kHeightSteps;
    int low = at->ground, high = at->height();
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++)
      {
        const Surface& next = at[dy * surfaces.pitch + dx];
        if (!next.is(kSurfaceMeasured)) continue;
        low = min_of(low, next.ground);
        high = max_of(high, next.height());
        const bool beside = (dx == 0) != (dy == 0), bare = 2 * (next.height() - next.ground) < step;
        const int rise =
            max_of(abs_of(next.ground - at->ground), abs_of(next.height() - at->height()));
        if (beside && bare && is_steep(kSteepEdge * rise, *config) &&
            blocks(judgement + dy * pitch + dx))
          return true;
      }
    return is_steep(at->height() - at->ground, *config) && static_cast<float>(high - low) > step;
  }
};

}  // namespace talus::kernels
