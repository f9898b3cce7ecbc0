#pragma once
#include "kernels/9_sparsity.h"

#include <tuple>

namespace talus::kernels
{
// Stage 8 (III-C): slope and step of the ground, roughness of the elevation, in a square
// neighbourhood. Sums over the neighbourhood are exact integers, so the order in which they are
// formed does not matter: here first along rows, then along columns. Signs are as printed in eq. 11
// and 12: a floor cell beside a wall lies below its neighbours and must not become rough for it.

/** Sums over the neighbours of one cell in its own row; x counts from the cell. Heights in
 * quantised steps. */
struct alignas(16) RowSums
{
  std::int32_t n = 0, x = 0, xx = 0, ground = 0, x_ground = 0, height = 0, lowest = 0x7fffffff,
               measured = 0;

  static constexpr auto fields()
  {
    return std::make_tuple(
        &RowSums::n, &RowSums::x, &RowSums::xx, &RowSums::ground, &RowSums::x_ground,
        &RowSums::height, &RowSums::lowest, &RowSums::measured);
  }

  /** Adds the cell at x = d. */
  TALUS_HD void add(const Surface& cell, int d)
  {
    const bool known = cell.known();
    const std::int32_t here = select(known, cell.ground, 0);
    n += select(known, 1, 0);
    x += select(known, d, 0);
    xx += select(known, d * d, 0);
    ground += here;
    x_ground += d * here;
    height += cell.height();
    lowest = min_of(lowest, select(known, cell.ground, 0x7fffffff));
    measured += cell.height_and_flags & kSurfaceMeasured;
  }
};

/** Sums over the whole neighbourhood of one cell. */
struct Moments
{
  std::int32_t n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, ground = 0, x_ground = 0, y_ground = 0,
               height = 0, lowest = 0x7fffffff, measured = 0;

  static constexpr auto fields()
  {
    return std::make_tuple(
        &Moments::n, &Moments::x, &Moments::y, &Moments::xx, &Moments::xy, &Moments::yy,
        &Moments::ground, &Moments::x_ground, &Moments::y_ground, &Moments::height,
        &Moments::lowest, &Moments::measured);
  }

  /** Adds the row at y = d. */
  TALUS_HD void add(const RowSums& row, int d)
  {
    n += row.n;
    x += row.x;
    y += d * row.n;
    xx += row.xx;
    xy += d * row.x;
    yy += d * d * row.n;
    ground += row.ground;
    x_ground += row.x_ground;
    y_ground += d * row.ground;
    height += row.height;
    lowest = min_of(lowest, row.lowest);
    measured += row.measured;
  }
};

/** a b - c d, exact: all sums are below 2^31 and their products here below 2^53. */
TALUS_HD double determinant(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d)
{
  return static_cast<double>(a) * static_cast<double>(b) -
         static_cast<double>(c) * static_cast<double>(d);
}

/** Whether the ground of all cells in the neighbourhood is known. */
TALUS_HD bool is_whole(const Moments& m, const Config& k)
{
  const int side = 2 * k.feature_radius_cells + 1;
  return m.n == side * side;
}

/** Slope angle [rad] of a plane from its gradient: numerators, and what they share. */
TALUS_HD float slope_angle(double x, double y, double share, const Config& k)
{
  const float to_metres = k.inverse_resolution / kHeightSteps;
  const float gx = static_cast<float>(x * share) * to_metres;
  const float gy = static_cast<float>(y * share) * to_metres;
  return arctangent(sqrtf(gx * gx + gy * gy));
}

/** That of the least-squares plane through the ground; NaN (of any bits) where fewer than three
 * cells, or cells in a line, leave it open. `kWhole`: of whole neighbourhoods, whose moments are
 * known; the same bits. */
template <bool kWhole>
TALUS_HD float slope_angle(const Moments& m, const Config& k)
{
  // Normal equations about the centroid; all sums are exact, only the last steps round.
  if constexpr (kWhole)
  {
    const int r = k.feature_radius_cells, side = 2 * r + 1;
    const double n = side * side, xx = n * (side * (r * (r + 1) * side / 3));
    return slope_angle(n * m.x_ground * xx, n * m.y_ground * xx, 1.0 / (xx * xx), k);
  }
  const double xx = determinant(m.n, m.xx, m.x, m.x);
  const double xy = determinant(m.n, m.xy, m.x, m.y);
  const double yy = determinant(m.n, m.yy, m.y, m.y);
  const double xg = determinant(m.n, m.x_ground, m.x, m.ground);
  const double yg = determinant(m.n, m.y_ground, m.y, m.ground);
  const double area = xx * yy - xy * xy;
  const double share = 1.0 / (area > 0.0 ? area : static_cast<double>(kNan));
  return slope_angle(xg * yy - yg * xy, yg * xx - xg * xy, share, k);
}

/** The layers of stages 8 and 9, window order. The first four may be null for those who want
 * traversability alone. */
struct FeatureLayers
{
  float *slope, *step, *roughness, *sparsity, *traversability;
  float* judged;  //!< traversability before CompleteObstacles, with a minus at low steps

  TALUS_HD void put_traversability(int o, float value) const
  {
    judged[o] = value;
    traversability[o] = abs_of(value);
  }
};

struct Features
{
  float slope, step, roughness;
};

/** Eq. 10 to 12, each in [0, 1]. `height` is the cell's own elevation, or ground where nothing
 * stands. */
template <bool kWhole>
TALUS_HD Features features_of(const Moments& m, std::int32_t height, const Config& k)
{
  const float metres = 1.0f / kHeightSteps, share = metres / static_cast<float>(m.n);
  const float own = static_cast<float>(height) * metres;
  const float mean_ground = static_cast<float>(m.ground) * share;
  const float mean_height = static_cast<float>(m.height) * share;
  const float lowest = static_cast<float>(m.lowest) * metres;
  const float step = (2.0f * own - lowest - mean_ground) * 0.5f;
  const float angle = slope_angle<kWhole>(m, k);
  return {
      select(is_known(angle), clamp01(1.0f - angle * k.inverse_slope_threshold), kNan),
      clamp01(1.0f - step * k.inverse_step_threshold),
      clamp01(1.0f - (own - mean_height) * k.inverse_roughness_threshold)};
}

/** Eq. 13: the weighted sum; zero, impassable, where any feature is, and with a minus where only
 * the slope is too steep, which takes another look: see LowStep. */
TALUS_HD float fuse_features(const Features& f, const Config& k)
{
  const bool impassable = (f.step == 0.0f) | (f.roughness == 0.0f);
  const float sum =
      k.weight_step * f.step + k.weight_slope * f.slope + k.weight_roughness * f.roughness;
  const float judged = select(f.slope == 0.0f, 0.0f - sum, select(is_known(f.slope), sum, kNan));
  return select(impassable, 0.0f, judged);
}

/** Whether a rise within a cell is steeper than the slope threshold; in quantised steps. */
TALUS_HD bool is_steep(int rise, const Config& k)
{
  return static_cast<float>(abs_of(rise)) > k.support_slope * k.resolution_m * kHeightSteps;
}

/** Whether a cell lies at a step that the robot takes, not on a slope as a plane through it would
 * say: within two cells nothing rises by more than four fifths of what it may, and the ground goes
 * on level to one side only (its foot or edge), or to both but not from one to the other (its
 * face). */
struct LowStep
{
  const Config& config;
  const Surfaces& surfaces;

  TALUS_HD bool is_at(int ix, int iy) const
  {
    const int n = config.cells;
    const bool inside = (ix > 2) & (iy > 2) & (ix < n - 3) & (iy < n - 3);
    const Surface* at = surfaces.cell + surfaces.at(ix, iy);
    if (!inside || !is_low_around(at)) return false;
    for (const int to : {-1, 1, -surfaces.pitch, surfaces.pitch})
    {
      const Surface &next = at[to], &before = at[-to];
      const bool beside = goes_on_level(next, to);
      const bool edge = beside && is_level(*at, next) && !is_level(*at, at[-2 * to]);
      const bool face = beside && goes_on_level(before, -to) &&
                        is_steep((next.ground - before.ground) / 2, config);
      if (edge || face) return true;
    }
    return false;
  }

 private:
  /** For two cells more. */
  TALUS_HD bool goes_on_level(const Surface& from, int to) const
  {
    return is_level(from, (&from)[to]) && is_level(from, (&from)[2 * to]);
  }
  TALUS_HD bool is_low_around(const Surface* at) const
  {
    int low = at->ground, high = at->height();
    for (int dy = -2; dy <= 2; dy++)
      for (int dx = -2; dx <= 2; dx++)
      {
        const Surface& next = at[dy * surfaces.pitch + dx];
        if (!next.known()) continue;
        low = min_of(low, next.ground);
        high = max_of(high, next.height());
      }
    return static_cast<float>(high - low) <= 0.8f * config.step_threshold_m * kHeightSteps;
  }
  TALUS_HD bool is_level(const Surface& a, const Surface& b) const
  {
    return a.known() && b.known() && !is_steep(b.ground - a.ground, config);
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
  const float* across_m;
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
  TALUS_HD bool concerns(int ix, int iy, const Moments& m) const
  {
    return may_be_sparse(ix, iy, m) | (out.judged[iy * cells + ix] < 0.0f);
  }
  /** What only few cells need. */
  TALUS_HD void finish(int ix, int iy, const Moments& m) const
  {
    const int o = iy * cells + ix;
    out.put_traversability(o, settle(ix, iy, m, out.judged[o], true));
  }
  /** All of that, for executors that go on with the result: returns the traversability before
   * CompleteObstacles, and puts only the parts, of cells that are the caller's `own`. */
  TALUS_HD float judge(int ix, int iy, const Moments& m, bool own) const
  {
    return settle(ix, iy, m, judge_most<false>(ix, iy, m, own), own);
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
        const int o = iy * cells + ix;
        out.slope[o] = select(known, f.slope, kNan);
        out.step[o] = select(known, f.step, kNan);
        out.roughness[o] = select(known, f.roughness, kNan);
        out.sparsity[o] = kNan;
      }
    // What no ray ever met, nor passed low over its ground, may be the inside of a thing.
    const bool judged = known & cell.is(kSurfaceReached);
    return select(judged, fuse_features(f, *config), kNan);
  }
  /** `judged`, unless stage 9 says otherwise, or it is the slope of a low step alone. */
  TALUS_HD float settle(int ix, int iy, const Moments& m, float judged, bool own) const
  {
    if (may_be_sparse(ix, iy, m) && is_near(ix, iy))
    {
      judged = suspicion_of(ix, iy);
      if constexpr (kParts)
        if (own) out.sparsity[iy * cells + ix] = judged;
    }
    return judged < 0.0f && !LowStep{*config, surfaces}.is_at(ix, iy) ? 0.0f : judged;
  }
  TALUS_HD bool may_be_sparse(int ix, int iy, const Moments& m) const
  {
    return neighbour(ix, iy).is(kSurfaceGuess) &
           dense_around(m.measured, config->feature_radius_cells);
  }
  /** Whether stage 9 looks there. The sensor's own cell lies on no line. */
  TALUS_HD bool is_near(int ix, int iy) const
  {
    const bool on_line = ix != cells / 2 || iy != cells / 2;
    return on_line && robot_m(ix, iy) <= config->sparsity_range_m;
  }
  TALUS_HD float suspicion_of(int ix, int iy) const
  {
    return sparsity(across_m[grid.at(ix, iy)], robot_m(ix, iy), *config);
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

  TALUS_HD bool concerns(int ix, int iy, int) const
  {
    return concerns(ix, iy, judged + iy * cells + ix, cells);
  }
  TALUS_HD void operator()(int ix, int iy, int) const
  {
    const int o = iy * cells + ix;
    if (joins(ix, iy, judged + o, cells)) traversability[o] = 0.0f;
  }
  /** The same for executors that have the judgement elsewhere: that of the cell is at `at`, its
   * neighbour's in the next row `pitch` behind it. */
  TALUS_HD void complete(int ix, int iy, const float* at, int pitch) const
  {
    const bool joined = concerns(ix, iy, at, pitch) && joins(ix, iy, at, pitch);
    traversability[iy * cells + ix] = joined ? 0.0f : abs_of(*at);
  }

 private:
  TALUS_HD bool concerns(int ix, int iy, const float* at, int pitch) const
  {
    const int n = cells;
    const bool inside = (ix > 0) & (iy > 0) & (ix < n - 1) & (iy < n - 1);
    return inside & !is_settled(at) & (around(at - pitch) | around(at) | around(at + pitch));
  }
  TALUS_HD bool joins(int ix, int iy, const float* at, int pitch) const
  {
    const bool traced = surfaces.cell[surfaces.at(ix, iy)].is(kSurfaceTraced);
    return between(at, pitch) || (traced && beside(at, pitch)) ||
           (is_known(*at) && at_steep_edge(ix, iy, at, pitch));
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
        if (beside && bare && is_steep(3 * rise, *config) && blocks(judgement + dy * pitch + dx))
          return true;
      }
    return is_steep(at->height() - at->ground, *config) && static_cast<float>(high - low) > step;
  }
};

}  // namespace talus::kernels
