#include <talus/nav/height_scan.h>

#include <algorithm>
#include <cmath>
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
constexpr float kSameSide_m = 0.04F;
constexpr float kMinForSpread = 5;  // neighbours, with the cell itself
constexpr float kMin_m2 = 2e-7F;
constexpr float kStepShare =
    0.5F;  // of a step in a cell or beside it: it may run through the point
/** Of the cell's deviation, for a neighbourhood whose middle is a cell away: at a rim of what was
 * seen only points are left that noise carried there, and all err alike. */
constexpr float kRim = 5;
/** Relief of presumed ground, which is a plane through the robot's feet. */
constexpr float kRelief_mpm = 0.014F, kFeet_m2 = 9e-6F;
constexpr float kRidge = 0.5F;  // cells^2: few neighbours tell no slope

float square(float x) { return x * x; }

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
        rise_m_(static_cast<float>(
            std::tan(map.parameters().slope_threshold_rad) * view_.window.resolution_m)),
        search_(static_cast<int>(kSearch_m / view_.window.resolution_m))
  {
  }

  ScannedHeight at(double x_m, double y_m) const
  {
    const Window& w = view_.window;
    const double column = (x_m - w.min_x_m()) / w.resolution_m;
    const double row = (y_m - w.min_y_m()) / w.resolution_m;
    const double reach = w.cells + search_;
    if (!(column > -search_ && row > -search_ && column < reach && row < reach))
      return {kUnknownHeight, kUnknownHeight, HeightOrigin::Unknown};
    const auto ix = static_cast<int>(std::floor(column)), iy = static_cast<int>(std::floor(row));
    if (is_known(ix, iy))
      return on_plane(
          ix, iy, static_cast<float>(column - ix - 0.5), static_cast<float>(row - iy - 0.5));
    return nearest(ix, iy);
  }

 private:
  bool is_inside(int ix, int iy) const
  {
    return ix >= 0 && iy >= 0 && ix < view_.window.cells && iy < view_.window.cells;
  }
  float top(int ix, int iy) const { return static_cast<float>(view_.top(view_.index(ix, iy))); }
  bool is_known(int ix, int iy) const { return is_inside(ix, iy) && !std::isnan(top(ix, iy)); }

  /** At a place of a known cell, in cells from its middle: least squares over nine cells. */
  ScannedHeight on_plane(int ix, int iy, float dx, float dy) const
  {
    const std::size_t cell = view_.index(ix, iy);
    const auto origin = origin_of(view_.state[cell]);
    const float middle_m = top(ix, iy);
    float step_m = std::fmax(middle_m - view_.ground[cell], 0.0F);  // 0 for NaN
    float n = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, zz = 0;
    for (int v = -1; v <= 1; v++)
      for (int u = -1; u <= 1; u++)
      {
        if (!is_inside(ix + u, iy + v)) continue;
        const std::size_t other = view_.index(ix + u, iy + v);
        const float off_m = top(ix + u, iy + v) - middle_m;
        const auto far = static_cast<float>(u * u + v * v == 2 ? 1.4142135 : u * u + v * v);
        if (!(std::abs(off_m) <= kSameSide_m + rise_m_ * far))
        {
          step_m = std::fmax(step_m, std::abs(off_m));  // not NaN
          continue;
        }
        if (origin == HeightOrigin::Measured && origin_of(view_.state[other]) != origin) continue;
        const auto a = static_cast<float>(u), b = static_cast<float>(v);
        n += 1, x += a, y += b, z += off_m;
        xx += a * a, xy += a * b, yy += b * b, xz += a * off_m, yz += b * off_m,
            zz += off_m * off_m;
      }
    xx += kRidge - x * x / n, yy += kRidge - y * y / n, xy -= x * y / n;
    xz -= x * z / n, yz -= y * z / n, zz -= z * z / n;
    const float det = xx * yy - xy * xy;
    const float along = (xz * yy - yz * xy) / det, across = (yz * xx - xz * xy) / det;
    const float off_m = z / n + along * (dx - x / n) + across * (dy - y / n);
    const float spread_m2 = std::max(0.0F, zz - along * xz - across * yz);
    const float own_m2 = std::max(view_.variance[cell], 0.0F);  // 0 for NaN
    float fit_m2 = spread_m2 / n;
    if (origin == HeightOrigin::Presumed)
    {
      const double away_m = std::hypot(view_.x_m(ix) - base_.x_m, view_.y_m(iy) - base_.y_m);
      fit_m2 += square(kRelief_mpm * static_cast<float>(away_m)) + kFeet_m2;
    }
    else if (origin == HeightOrigin::Measured && n >= kMinForSpread)
      fit_m2 = fit_m2 / (n - 3) +  // a plane has three parameters
               square(kRim * (x * x + y * y) / (n * n)) * own_m2 + kMin_m2;
    else
      fit_m2 += own_m2;
    // What rises as steeply as what blocks is rather an edge that noise has smeared.
    const float edge_m = (along * along + across * across) / rise_m_;
    const float sigma_m2 = fit_m2 + square(kStepShare * step_m) + square(edge_m);
    return {middle_m + off_m, std::sqrt(sigma_m2), origin};
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
  float rise_m_;  //!< of the steepest slope, in a cell
  int search_;  //!< cells
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
  const Heights heights(map, base);
  const double c = std::cos(base.yaw_rad), s = std::sin(base.yaw_rad);
  for (std::size_t i = 0; i < out.size(); i++)
  {
    const auto [x, y] = points[i];
    out[i] = heights.at(base.x_m + c * x - s * y, base.y_m + s * x + c * y);
  }
  return out;
}

}  // namespace talus::nav
