#pragma once
#include "kernels/map.h"

#include <initializer_list>

namespace talus::kernels
{
// Stage 7 (III-C): slope and step of the ground, roughness of the elevation, in a square
// neighbourhood. Sums are exact integers, so that their order does not matter: first along rows,
// then along columns. Signs are as printed in eq. 11 and 12: a floor cell beside a wall lies below
// its neighbours and must not become rough for it.

/** Sums over a cell's neighbours in its row; x counts from the cell, heights are quantised. */
struct alignas(16) RowSums
{
  std::int32_t n = 0, x = 0, xx = 0, ground = 0, x_ground = 0, height = 0, lowest = 0x7fffffff;

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
  }
};

struct Moments
{
  std::int32_t n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, ground = 0, x_ground = 0, y_ground = 0,
               height = 0, lowest = 0x7fffffff;

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
  }
};

/** a b - c d, exact: all sums are below 2^31 and their products here below 2^53. */
TALUS_HD double determinant(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d)
{
  return static_cast<double>(a) * static_cast<double>(b) -
         static_cast<double>(c) * static_cast<double>(d);
}

TALUS_HD bool is_whole(const Moments& m, const Config& k)
{
  const int side = 2 * k.feature_radius_cells + 1;
  return m.n == side * side;
}

/** Slope angle of a plane [rad] from its gradient (x, y) / share. */
TALUS_HD float slope_angle(double x, double y, double share, const Config& k)
{
  const float to_metres = k.inverse_resolution / kHeightUnits;
  const float gx = static_cast<float>(x * share) * to_metres;
  const float gy = static_cast<float>(y * share) * to_metres;
  return arctangent(sqrtf(gx * gx + gy * gy));
}

/** Slope angle of the least-squares plane through the ground; NaN where fewer than three cells, or
 * cells in a line, leave it open. `kWhole`: whole neighbourhoods, whose moments are constants; the
 * bits are the same. */
template <bool kWhole>
TALUS_HD float slope_angle(const Moments& m, const Config& k)
{
  // Normal equations about the centroid; all sums are exact, only what follows rounds.
  if constexpr (kWhole)
  {
    const int r = k.feature_radius_cells, side = 2 * r + 1;
    const double n = side * side, xx = n * (side * (r * (r + 1) * side / 3));
    return slope_angle(m.x_ground * (n * xx), m.y_ground * (n * xx), 1.0 / (xx * xx), k);
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

struct Features
{
  float slope, step, roughness;
};

/** Eq. 10 to 12, each in [0, 1]. `height`: elevation, or the ground without an object. */
template <bool kWhole>
TALUS_HD Features features_of(const Moments& m, std::int32_t height, const Config& k)
{
  const float metres = 1.0f / kHeightUnits, share = metres / static_cast<float>(m.n);
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

/** The result for a cell before its neighbours are looked at. */
enum Passability : std::uint8_t
{
  kPassable = 0,  //!< or not judged; its neighbours may make it impassable
  kImpassable = 1,
  kSteep = 2  //!< only its slope is too steep; after LowStep: it is a low step
};
struct Judgement
{
  float score;  //!< traversability; for kSteep without the slope
  std::int32_t passability;
};

/** Eq. 13: weighted sum, zero where step or roughness is. If only the slope is, LowStep decides. */
TALUS_HD Judgement fuse_features(const Features& f, const Config& k)
{
  const bool impassable = (f.step == 0.0f) | (f.roughness == 0.0f);
  const float sum =
      k.weight_step * f.step + k.weight_slope * f.slope + k.weight_roughness * f.roughness;
  return {
      select(impassable, 0.0f, select(is_known(f.slope), sum, kNan)),
      select(!impassable & (f.slope == 0.0f), kSteep, kPassable)};
}

/** Whether a rise within a cell, in 1 / kHeightUnits m, is steeper than the slope threshold. */
TALUS_HD bool is_steep(int rise, const Config& k)
{
  return static_cast<float>(abs_of(rise)) > k.max_slope * k.resolution_m * kHeightUnits;
}

/** Whether a cell lies at a step that the robot takes, although a plane through it is steep. Within
 * two cells nothing may rise by more than four fifths of the threshold. The ground goes on level to
 * one side only (foot or edge), or to both sides but not across (face). */
struct LowStep
{
  const Map& m;

  TALUS_HD bool is_at(int ix, int iy) const
  {
    const int n = m.k.cells;
    if (!on(kLowSteps, m.k)) return false;
    const bool inside = (ix > 2) & (iy > 2) & (ix < n - 3) & (iy < n - 3);
    const Surface* at = m.judged_surface + m.surface_at(ix, iy);
    if (!inside || !is_low_around(at)) return false;
    for (const int to : {-1, 1, -m.surface_pitch(), m.surface_pitch()})
    {
      const Surface &next = at[to], &before = at[-to];
      const bool beside = goes_on_level(next, to);
      const bool edge = beside && is_level(*at, next) && !is_level(*at, at[-2 * to]);
      const bool face =
          beside && goes_on_level(before, -to) && is_steep((next.ground - before.ground) / 2, m.k);
      if (edge || face) return true;
    }
    return false;
  }

 private:
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
        const Surface& next = at[dy * m.surface_pitch() + dx];
        if (!next.known()) continue;
        low = min_of(low, next.ground);
        high = max_of(high, next.height());
      }
    return static_cast<float>(high - low) <= kLowStep_steps * m.k.step_threshold_m * kHeightUnits;
  }
  TALUS_HD bool is_level(const Surface& a, const Surface& b) const
  {
    return a.known() && b.known() && !is_steep(b.ground - a.ground, m.k);
  }
};

}  // namespace talus::kernels
