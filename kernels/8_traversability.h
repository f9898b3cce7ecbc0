#pragma once
#include "kernels/9_sparsity.h"

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
  std::int32_t n, x, xx, ground, x_ground, height, lowest, measured;
};

/** Sums over the whole neighbourhood of one cell. */
struct Moments
{
  std::int32_t n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, ground = 0, x_ground = 0, y_ground = 0,
               height = 0, lowest = 0x7fffffff, measured = 0;
};

/** a b - c d, exact. */
TALUS_HD double determinant(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d)
{
  return static_cast<double>(static_cast<std::int64_t>(a) * b - static_cast<std::int64_t>(c) * d);
}

/** `rows(y)` gives the sums of row y. */
template <class Rows>
TALUS_HD Moments sum_rows(const Rows& rows, int cells, int radius, int iy)
{
  Moments m;
  for (int y = max_of(iy - radius, 0); y <= min_of(iy + radius, cells - 1); y++)
  {
    const RowSums& row = rows(y);
    const int d = y - iy;
    m.n += row.n;
    m.x += row.x;
    m.y += d * row.n;
    m.xx += row.xx;
    m.xy += d * row.x;
    m.yy += d * d * row.n;
    m.ground += row.ground;
    m.x_ground += row.x_ground;
    m.y_ground += d * row.ground;
    m.height += row.height;
    m.lowest = min_of(m.lowest, row.lowest);
    m.measured += row.measured;
  }
  return m;
}

/** Slope angle [rad] of the least-squares plane through the ground; NaN where fewer than three
 * cells, or cells in a line, leave it open. */
TALUS_HD float slope_angle(const Moments& m, const Config& k)
{
  // Normal equations about the centroid; all sums are exact, only the last steps round.
  const double xx = determinant(m.n, m.xx, m.x, m.x);
  const double xy = determinant(m.n, m.xy, m.x, m.y);
  const double yy = determinant(m.n, m.yy, m.y, m.y);
  const double xg = determinant(m.n, m.x_ground, m.x, m.ground);
  const double yg = determinant(m.n, m.y_ground, m.y, m.ground);
  const double area = xx * yy - xy * xy;
  if (m.n < 3 || !(area > 0.0)) return kNan;
  const float to_metres = k.inverse_resolution / kHeightSteps;
  const float gx = static_cast<float>((xg * yy - yg * xy) / area) * to_metres;
  const float gy = static_cast<float>((yg * xx - xg * xy) / area) * to_metres;
  return arctangent(sqrtf(gx * gx + gy * gy));
}

/** The layers of stages 8 and 9, window order. */
struct FeatureLayers
{
  float *slope, *step, *roughness, *sparsity, *traversability;
};

struct Features
{
  float slope, step, roughness;
};

/** Eq. 10 to 12, each in [0, 1]. `height` is the cell's own elevation, or ground where nothing
 * stands. */
TALUS_HD Features features_of(const Moments& m, std::int32_t height, const Config& k)
{
  const float metres = 1.0f / kHeightSteps;
  const float n = static_cast<float>(m.n);
  const float own = static_cast<float>(height) * metres;
  const float mean_ground = static_cast<float>(m.ground) * metres / n;
  const float mean_height = static_cast<float>(m.height) * metres / n;
  const float lowest = static_cast<float>(m.lowest) * metres;
  const float step = (2.0f * own - lowest - mean_ground) * 0.5f;
  const float angle = slope_angle(m, k);
  return {
      is_known(angle) ? clamp01(1.0f - angle * k.inverse_slope_threshold) : kNan,
      clamp01(1.0f - step * k.inverse_step_threshold),
      clamp01(1.0f - (own - mean_height) * k.inverse_roughness_threshold)};
}

/** Eq. 13: the weighted sum; impassable where any feature is. */
TALUS_HD float fuse_features(const Features& f, const Config& k)
{
  if (!is_known(f.slope)) return f.step == 0.0f || f.roughness == 0.0f ? 0.0f : kNan;
  if (f.slope == 0.0f || f.step == 0.0f || f.roughness == 0.0f) return 0.0f;
  return k.weight_step * f.step + k.weight_slope * f.slope + k.weight_roughness * f.roughness;
}

/** Stages 8 and 9 on cell (ix, iy): first along rows, then across them. */
struct ComputeFeatures
{
  using Row = RowSums;
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  Surfaces surfaces;
  const std::uint32_t* marks;
  FeatureLayers out;

  TALUS_HD RowSums row(int ix, int iy) const
  {
    const int radius = config->feature_radius_cells;
    const Surface* centre = surfaces.cell + surfaces.at(ix, iy);
    RowSums s{0, 0, 0, 0, 0, 0, 0x7fffffff, 0};
    for (int first = -radius; first <= radius; first += kBatch)
    {
      // Loads first, so that they do not wait for each other.
      Surface near[kBatch];
      for (int b = 0; b < kBatch; b++)
        near[b] = first + b <= radius ? centre[first + b] : Surface{kNoHeight, 0};
      for (int b = 0; b < kBatch; b++)
        if (near[b].known()) add(s, first + b, near[b]);
    }
    return s;
  }

  template <class Rows>
  TALUS_HD void operator()(int ix, int iy, const Rows& rows) const
  {
    const int n = config->cells, o = iy * n + ix;
    Features f{kNan, kNan, kNan};
    float sparse = kNan, traversability = kNan;
    const Surface own = surfaces.cell[surfaces.at(ix, iy)];
    if (own.known())
    {
      const Moments m = sum_rows(rows, n, config->feature_radius_cells, iy);
      f = features_of(m, own.height(), *config);
      traversability =
          passed_or_met(storage_index(*frame, n, ix, iy)) ? fuse_features(f, *config) : kNan;
      if (is_sparse(m, storage_index(*frame, n, ix, iy)))
        judge_sparse_cell(ix, iy, sparse, traversability);
    }
    out.slope[o] = f.slope;
    out.step[o] = f.step;
    out.roughness[o] = f.roughness;
    out.sparsity[o] = sparse;
    out.traversability[o] = traversability;
  }

 private:
  static constexpr int kBatch = 8;

  static TALUS_HD void add(RowSums& s, int d, const Surface& cell)
  {
    s.n += 1;
    s.x += d;
    s.xx += d * d;
    s.ground += cell.ground;
    s.x_ground += d * cell.ground;
    s.height += cell.height();
    s.lowest = min_of(s.lowest, cell.ground);
    s.measured += cell.measured();
  }

  /** What no ray ever met, nor passed low over its ground, may be the inside of a thing. */
  TALUS_HD bool passed_or_met(int i) const
  {
    return store.state[i] == kMeasured || (store.passed[i] & kPassedLow) ||
           is_known(store.elevation_m[i]);
  }

  TALUS_HD bool is_sparse(const Moments& m, int i) const
  {
    return store.state[i] == kFilledOneSided && !is_known(store.elevation_m[i]) &&
           dense_around(m.measured, config->feature_radius_cells);
  }

  TALUS_HD void judge_sparse_cell(int ix, int iy, float& sparse, float& traversability) const
  {
    const int half = config->cells / 2;
    if (ix == half && iy == half) return;  // the sensor's own cell lies on no line
    const auto search = line_search(*config, *frame, store, marks, ix - half, iy - half);
    const float robot_m = static_cast<float>(search.place) * search.step_m;
    if (robot_m > config->sparsity_range_m) return;
    traversability = sparse = sparsity(search, robot_m, *config);
  }
};

/** The last step of stage 8: a cell between two impassable ones, on opposite sides, is impassable.
 * No robot fits through one cell, and things that rays pass through are hit in some cells only. */
struct CloseGaps
{
  const Config* config;
  const float* judged;  //!< window order
  float* traversability;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int n = config->cells, o = iy * n + ix;
    const bool inside = ix > 0 && iy > 0 && ix < n - 1 && iy < n - 1;
    traversability[o] = inside && between(judged + o, n) ? 0.0f : judged[o];
  }

 private:
  static TALUS_HD bool between(const float* at, int n)
  {
    return both_blocked(at, 1) || both_blocked(at, n) || both_blocked(at, n + 1) ||
           both_blocked(at, n - 1);
  }
  static TALUS_HD bool both_blocked(const float* at, int step)
  {
    return at[-step] == 0.0f && at[step] == 0.0f;
  }
};

}  // namespace talus::kernels
