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
struct RowSums
{
  std::int32_t n, x, xx, ground, x_ground, height, lowest, measured;
};

/** The same as arrays in window order. */
struct RowSumArrays
{
  std::int32_t *n, *x, *xx, *ground, *x_ground, *height, *lowest, *measured;

  TALUS_HD void store(int i, const RowSums& s) const
  {
    n[i] = s.n, x[i] = s.x, xx[i] = s.xx, ground[i] = s.ground, x_ground[i] = s.x_ground;
    height[i] = s.height, lowest[i] = s.lowest, measured[i] = s.measured;
  }
};

struct SumRow
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  Surfaces surfaces;
  RowSumArrays rows;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int n = config->cells, radius = config->feature_radius_cells;
    RowSums s{0, 0, 0, 0, 0, 0, 0x7fffffff, 0};
    const int centre = surfaces.at(ix, iy);
    for (int d = -radius; d <= radius; d++)
    {
      const std::int32_t ground = surfaces.ground[centre + d];
      if (ground == kNoHeight) continue;
      s.n += 1;
      s.x += d;
      s.xx += d * d;
      s.ground += ground;
      s.x_ground += d * ground;
      s.height += surfaces.height[centre + d];
      s.lowest = min_of(s.lowest, ground);
      s.measured += store.state[storage_index(*frame, n, ix + d, iy)] == kMeasured;
    }
    rows.store(iy * n + ix, s);
  }
};

/** Sums over the whole neighbourhood of one cell. */
struct Moments
{
  std::int64_t n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, ground = 0, x_ground = 0, y_ground = 0,
               height = 0;
  std::int32_t lowest = 0x7fffffff, measured = 0;
};

TALUS_HD Moments sum_rows(const RowSumArrays& rows, int cells, int radius, int ix, int iy)
{
  Moments m;
  for (int y = max_of(iy - radius, 0); y <= min_of(iy + radius, cells - 1); y++)
  {
    const int i = y * cells + ix, d = y - iy;
    m.n += rows.n[i];
    m.x += rows.x[i];
    m.y += d * rows.n[i];
    m.xx += rows.xx[i];
    m.xy += d * rows.x[i];
    m.yy += d * d * rows.n[i];
    m.ground += rows.ground[i];
    m.x_ground += rows.x_ground[i];
    m.y_ground += static_cast<std::int64_t>(d) * rows.ground[i];
    m.height += rows.height[i];
    m.lowest = min_of(m.lowest, rows.lowest[i]);
    m.measured += rows.measured[i];
  }
  return m;
}

/** Slope angle [rad] of the least-squares plane through the ground; NaN where fewer than three
 * cells, or cells in a line, leave it open. */
TALUS_HD float slope_angle(const Moments& m, const Config& k)
{
  // Normal equations about the centroid; all sums are exact, only the last steps round.
  const double xx = static_cast<double>(m.n * m.xx - m.x * m.x);
  const double xy = static_cast<double>(m.n * m.xy - m.x * m.y);
  const double yy = static_cast<double>(m.n * m.yy - m.y * m.y);
  const double xg = static_cast<double>(m.n * m.x_ground - m.x * m.ground);
  const double yg = static_cast<double>(m.n * m.y_ground - m.y * m.ground);
  const double determinant = xx * yy - xy * xy;
  if (m.n < 3 || !(determinant > 0.0)) return kNan;
  const float to_metres = k.inverse_resolution / kHeightSteps;
  const float gx = static_cast<float>((xg * yy - yg * xy) / determinant) * to_metres;
  const float gy = static_cast<float>((yg * xx - xg * xy) / determinant) * to_metres;
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
  return {
      clamp01(1.0f - slope_angle(m, k) * k.inverse_slope_threshold),
      clamp01(1.0f - step * k.inverse_step_threshold),
      clamp01(1.0f - (own - mean_height) * k.inverse_roughness_threshold)};
}

/** Eq. 13: the weighted sum; impassable where any feature is. */
TALUS_HD float fuse_features(const Features& f, const Config& k)
{
  if (f.slope == 0.0f || f.step == 0.0f || f.roughness == 0.0f) return 0.0f;
  return k.weight_step * f.step + k.weight_slope * f.slope + k.weight_roughness * f.roughness;
}

/** Stages 8 and 9 on cell (ix, iy). */
struct ComputeFeatures
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  Surfaces surfaces;
  RowSumArrays rows;
  const std::uint32_t* marks;
  FeatureLayers out;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int n = config->cells, o = iy * n + ix;
    out.slope[o] = out.step[o] = out.roughness[o] = out.sparsity[o] = out.traversability[o] = kNan;
    const std::int32_t height = surfaces.height[surfaces.at(ix, iy)];
    if (height == kNoHeight) return;
    const Moments m = sum_rows(rows, n, config->feature_radius_cells, ix, iy);
    const Features f = features_of(m, height, *config);
    out.slope[o] = f.slope;
    out.step[o] = f.step;
    out.roughness[o] = f.roughness;
    out.traversability[o] = fuse_features(f, *config);

    const int i = storage_index(*frame, n, ix, iy);
    if (store.state[i] != kFilledOneSided || is_known(store.elevation_m[i])) return;
    if (!dense_around(m.measured, config->feature_radius_cells)) return;
    judge_sparse_cell(ix, iy, o);
  }

 private:
  TALUS_HD void judge_sparse_cell(int ix, int iy, int o) const
  {
    const int half = config->cells / 2;
    if (ix == half && iy == half) return;  // the sensor's own cell lies on no line
    const LineSearch search = line_search(*config, *frame, store, marks, ix - half, iy - half);
    const float robot_m = static_cast<float>(search.ring) * search.ring_length_m;
    if (robot_m > config->sparsity_range_m) return;
    out.sparsity[o] = sparsity(search, robot_m, *config);
    out.traversability[o] = out.sparsity[o];
  }
};

}  // namespace talus::kernels
