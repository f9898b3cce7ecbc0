#include <talus/nav/height_scan.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>

#include "surface_view.h"

namespace talus::nav
{
namespace
{
constexpr float kUnknownHeight = std::numeric_limits<float>::quiet_NaN();
constexpr double kSearch_m = 1, kGrows_mpm = 0.3;
/** A neighbour this much higher or lower, beyond what a slope explains, is behind a step. */
constexpr double kSameSide_m = 0.04;
/** The height of a cell is the highest in it, so its lower part may reach under a point: of the
 * square of a step down beside it, half. */
constexpr float kStepShare = 0.5F;
/** Where the two surfaces of cells differ, the height lies anywhere between them. */
constexpr float kUniform = 1.0F / 3;
/** Weight of what the map says of a cell against what one neighbour says. */
constexpr float kOwnWeight = 0.03F;
/** Of the variance of a cell, common to its neighbours: range noise carries points across cells. */
constexpr float kCommon = 0.01F;
/** Of the cell's deviation, for a neighbourhood whose middle is a cell away: at a rim of what was
 * seen only points are left that noise carried there, and all err alike. */
constexpr float kRim = 2.5F;
/** Presumed ground is a plane through the robot's feet; the ground that is seen this far behind its
 * end, in so many directions, says how well it holds. */
constexpr int kBehindRim_cells = 4, kStride_cells = 2;
constexpr std::array kCosines{1.0, M_SQRT1_2, 0.0, -M_SQRT1_2, -1.0, -M_SQRT1_2, 0.0, M_SQRT1_2};
constexpr float kRelief_mpm = 0.014F;  // where none is seen
constexpr float kFeet_m2 = 9e-6F, kMedianOfDeviation = 0.6745F;
constexpr float kRidge = 0.5F;  // cells^2: some of nine neighbours tell no slope

float square(float x) { return x * x; }

/** floor() of cells in or near a window, without a call. */
int whole(double cells)
{
  const int towards_zero = static_cast<int>(cells);
  return towards_zero - static_cast<int>(cells < towards_zero);
}

HeightOrigin origin_of(float state)
{
  if (state == static_cast<float>(CellState::Measured)) return HeightOrigin::Measured;
  if (state == static_cast<float>(CellState::Presumed)) return HeightOrigin::Presumed;
  return state == static_cast<float>(CellState::Unknown) ? HeightOrigin::Unknown
                                                         : HeightOrigin::Filled;
}

class Heights
{
 public:
  Heights(const MapView& map, const Pose2& base)
      : view_(map),
        base_(base),
        search_(static_cast<int>(kSearch_m / view_.window.resolution_m)),
        cell_m_(static_cast<float>(view_.window.resolution_m))
  {
    const double rise_m =
        std::tan(map.parameters().slope_threshold_rad) * view_.window.resolution_m;
    for (std::size_t i = 0; i < same_side_m_.size(); i++)
      same_side_m_[i] = static_cast<float>(kSameSide_m + rise_m * std::sqrt(i));
  }

  ScannedHeight at(double x_m, double y_m)
  {
    const double column = column_of(x_m), row = row_of(y_m);
    const double reach = view_.window.cells + search_;
    if (!(column > -search_ && row > -search_ && column < reach && row < reach))
      return {kUnknownHeight, kUnknownHeight, HeightOrigin::Unknown};
    const int ix = whole(column), iy = whole(row);
    if (is_known(ix, iy))
      return on_plane(
          ix, iy, static_cast<float>(column - ix - 0.5), static_cast<float>(row - iy - 0.5));
    return nearest(ix, iy);
  }

 private:
  double column_of(double x_m) const
  {
    return (x_m - view_.window.min_x_m()) / view_.window.resolution_m;
  }
  double row_of(double y_m) const
  {
    return (y_m - view_.window.min_y_m()) / view_.window.resolution_m;
  }
  bool is_inside(int ix, int iy) const
  {
    return ix >= 0 && iy >= 0 && ix < view_.window.cells && iy < view_.window.cells;
  }
  static float higher(float ground_m, float elevation_m)
  {
    const float known_m = std::isnan(ground_m) ? elevation_m : ground_m;
    return elevation_m > known_m ? elevation_m : known_m;
  }
  float top(std::size_t cell) const { return higher(view_.ground[cell], view_.elevation[cell]); }
  bool is_known(int ix, int iy) const
  {
    return is_inside(ix, iy) && !std::isnan(top(view_.index(ix, iy)));
  }

  /** At a place of a known cell, in cells from its middle: least squares over nine cells, judged by
   * how well these and eight farther ones lie on that plane. */
  ScannedHeight on_plane(int ix, int iy, float dx, float dy)
  {
    const std::size_t cell = view_.index(ix, iy);
    const auto pitch = static_cast<std::ptrdiff_t>(view_.window.cells);
    const float* const ground_m = view_.ground.data() + cell;
    const float* const elevation_m = view_.elevation.data() + cell;
    const float* const states = view_.state.data() + cell;
    const auto origin = origin_of(*states);
    const bool measured = origin == HeightOrigin::Measured;
    const bool inner = is_inside(ix - 2, iy - 2) && is_inside(ix + 2, iy + 2);
    const float middle_m = higher(*ground_m, *elevation_m);
    float step_m = 0, seen = 0, seen_x = 0, seen_y = 0, off_m = 0, gap_m = 0;
    // Whether a cell is as sure, and not behind a step; then its height above the middle is off_m,
    // and gap_m that above its own ground.
    const auto look = [&](int u, int v)
    {
      if (!inner && !is_inside(ix + u, iy + v)) return false;
      const std::ptrdiff_t other = u + v * pitch;
      const float top_m = higher(ground_m[other], elevation_m[other]);
      off_m = top_m - middle_m;
      gap_m = top_m - ground_m[other];
      const bool sure = measured ? states[other] == *states : !std::isnan(off_m);
      if (sure) seen += 1, seen_x += static_cast<float>(u), seen_y += static_cast<float>(v);
      const int far2 = u * u + v * v;
      if (std::abs(off_m) <= same_side_m_[static_cast<std::size_t>(far2)]) return sure;
      if (far2 <= 2 && -off_m > step_m) step_m = -off_m;
      return false;
    };
    float n = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, zz = 0, gaps_m = 0;
#pragma GCC unroll 3
    for (int v = -1; v <= 1; v++)
#pragma GCC unroll 3
      for (int u = -1; u <= 1; u++)
      {
        if (!look(u, v)) continue;
        const auto a = static_cast<float>(u), b = static_cast<float>(v);
        n += 1, x += a, y += b, z += off_m;
        xx += a * a, xy += a * b, yy += b * b, xz += a * off_m, yz += b * off_m,
            zz += off_m * off_m;
        if (gap_m > 0) gaps_m += gap_m;
      }
    const float ridge = n < 9 ? kRidge : 0, share = 1 / n;
    x *= share, y *= share, z *= share;
    xx += ridge - n * x * x, yy += ridge - n * y * y, xy -= n * x * y;
    xz -= n * x * z, yz -= n * y * z, zz -= n * z * z;
    const float inverse = 1 / (xx * yy - xy * xy);
    const float along = (xz * yy - yz * xy) * inverse, across = (yz * xx - xz * xy) * inverse;
    const auto off_at = [&](float u, float v) { return z + along * (u - x) + across * (v - y); };
    // Variance of the plane there, of cells with variance 1.
    const auto doubt_at = [&](float u, float v)
    {
      u -= x, v -= y;
      return share + (u * u * yy - 2 * u * v * xy + v * v * xx) * inverse;
    };
    const float own_m2 = std::max(view_.variance[cell], 0.0F);  // 0 for NaN
    float misfit_m2 = std::max(0.0F, zz - along * xz - across * yz) + kOwnWeight * own_m2;
    float freedom = n - std::min(n, 3.0F) + kOwnWeight;  // a plane has three parameters
#pragma GCC unroll 3
    for (int v = -2; v <= 2; v += 2)
#pragma GCC unroll 3
      for (int u = -2; u <= 2; u += v ? 2 : 4)
      {
        if (!look(u, v)) continue;
        const auto a = static_cast<float>(u), b = static_cast<float>(v);
        misfit_m2 += square(off_m - off_at(a, b)) / (1 + doubt_at(a, b));
        freedom += 1;
      }
    float sigma_m2 = misfit_m2 / freedom * (doubt_at(dx, dy) + kCommon) +
                     kUniform * square(gaps_m * share) + kStepShare * square(step_m);
    if (origin == HeightOrigin::Presumed)
      sigma_m2 += square(relief_mpm() * away_m(ix, iy)) + kFeet_m2;
    else if (measured)
      sigma_m2 += square(kRim * (seen_x * seen_x + seen_y * seen_y) / square(seen)) * own_m2;
    else
      sigma_m2 += own_m2 * square(1 + std::sqrt(square(along) + square(across)) / cell_m_);
    return {middle_m + off_at(dx, dy), std::sqrt(sigma_m2), origin};
  }

  float away_m(int ix, int iy) const
  {
    return static_cast<float>(std::hypot(view_.x_m(ix) - base_.x_m, view_.y_m(iy) - base_.y_m));
  }

  /** Of presumed ground. */
  float relief_mpm()
  {
    if (!std::isnan(relief_mpm_)) return relief_mpm_;
    std::vector<float> found;
    const auto start = view_.window.index_at(base_.x_m, base_.y_m);
    for (std::size_t i = 0; start && i < kCosines.size(); i++)
      if (const auto error = error_along(top(*start), kCosines[i], kCosines[(i + 6) % 8]))
        found.push_back(*error);
    relief_mpm_ = kRelief_mpm;
    if (!found.empty())
    {
      const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
      std::nth_element(found.begin(), middle, found.end());
      relief_mpm_ = *middle / kMedianOfDeviation;
    }
    return relief_mpm_;
  }

  /** By how much the presumed ground of a direction misses the measured one behind it [m/m]. */
  std::optional<float> error_along(float start_m, double c, double s) const
  {
    const double column = column_of(base_.x_m), row = row_of(base_.y_m);
    float end_m = kUnknownHeight, end_cells = 1;
    int behind = 0;
    for (int i = kStride_cells;; i += kStride_cells)
    {
      const int ix = whole(column + c * i), iy = whole(row + s * i);
      if (!is_inside(ix, iy)) return std::nullopt;
      const std::size_t cell = view_.index(ix, iy);
      const auto origin = origin_of(view_.state[cell]);
      const auto cells = static_cast<float>(i);
      if (origin == HeightOrigin::Presumed) end_m = top(cell), end_cells = cells;
      const float slope = (end_m - start_m) / end_cells;  // NaN: none yet
      if (origin == HeightOrigin::Measured && !std::isnan(slope) &&
          (behind += kStride_cells) == kBehindRim_cells)
        return std::abs((top(cell) - start_m) / cells - slope) / cell_m_;
    }
  }

  /** Ring by ring around an unknown cell. */
  ScannedHeight nearest(int ix, int iy) const
  {
    std::optional<std::size_t> best;
    int best2 = search_ * search_ + 1;
    for (int r = 1; r <= search_ && r * r < best2; r++)
      for (int v = -r; v <= r; v++)
        for (int u = -r; u <= r; u += std::abs(v) == r ? 1 : 2 * r)
        {
          if (u * u + v * v >= best2 || !is_known(ix + u, iy + v)) continue;
          best = view_.index(ix + u, iy + v);
          best2 = u * u + v * v;
        }
    if (!best) return {kUnknownHeight, kUnknownHeight, HeightOrigin::Unknown};
    const double away_m = std::sqrt(best2) * view_.window.resolution_m;
    const double own_m2 = std::max(view_.variance[*best], 0.0F);
    return {
        static_cast<float>(view_.top(*best)),
        static_cast<float>(std::sqrt(own_m2 + kGrows_mpm * kGrows_mpm * away_m * away_m)),
        HeightOrigin::Unknown};
  }

  SurfaceView view_;
  Pose2 base_;
  std::array<float, 9> same_side_m_;  //!< by the square of the distance in cells
  int search_;  //!< cells
  float cell_m_;
  float relief_mpm_ = kUnknownHeight;  //!< NaN: not asked for yet
};
}  // namespace

std::vector<ScannedHeight> height_scan(
    const MapView& map, const Pose& T_map_base, const std::vector<Point2>& points)
{
  const Pose2 base = from_above(T_map_base);
  if (!std::isfinite(base.x_m + base.y_m + base.yaw_rad))
    throw std::invalid_argument("height_scan(): the pose of the robot is not finite");
  std::vector<ScannedHeight> out(
      points.size(), {kUnknownHeight, kUnknownHeight, HeightOrigin::Unknown});
  if (map.empty()) return out;
  Heights heights(map, base);
  const double c = std::cos(base.yaw_rad), s = std::sin(base.yaw_rad);
  for (std::size_t i = 0; i < out.size(); i++)
  {
    const auto [x, y] = points[i];
    out[i] = heights.at(base.x_m + c * x - s * y, base.y_m + s * x + c * y);
  }
  return out;
}

}  // namespace talus::nav
