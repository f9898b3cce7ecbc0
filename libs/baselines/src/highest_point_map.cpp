#include <talus/baselines/features.h>
#include <talus/baselines/highest_point_map.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::baselines
{
namespace
{
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kGate = 2.5f;  //!< Mahalanobis distance, as elevation_mapping's default
constexpr double kCleanupPeriod_s = 1.0;
constexpr float kCleanupDeviations = 3.0f;

float point_variance(const Parameters& p, float range_m)
{
  const auto deviation = static_cast<float>(p.c_beam_m + p.a_beam * range_m);
  return deviation * deviation;
}

}  // namespace

HighestPointMap::HighestPointMap(const Parameters& parameters) : parameters_(parameters) {}

void HighestPointMap::move_to(const Window& window)
{
  const Cell empty{kNan, kNan, 0.0};
  std::vector<Cell> moved(
      static_cast<std::size_t>(window.cells) * static_cast<std::size_t>(window.cells), empty);
  for (int iy = 0; iy < window_.cells; ++iy)
    for (int ix = 0; ix < window_.cells; ++ix)
    {
      const std::int64_t x = ix + window_.min_cell_x - window.min_cell_x;
      const std::int64_t y = iy + window_.min_cell_y - window.min_cell_y;
      if (x < 0 || y < 0 || x >= window.cells || y >= window.cells) continue;
      moved[static_cast<std::size_t>(y * window.cells + x)] =
          cells_[static_cast<std::size_t>(iy * window_.cells + ix)];
    }
  cells_ = std::move(moved);
  window_ = window;
}

void HighestPointMap::fuse(Cell& c, const MapPoint& p, double stamp_s) const
{
  const float variance = point_variance(parameters_, p.range_m);
  const float difference = p.z_m - c.height_m;
  if (std::isnan(c.height_m) || difference > kGate * std::sqrt(c.variance_m2))
  {
    c = {p.z_m, variance, stamp_s};
    return;
  }
  if (difference < -kGate * std::sqrt(c.variance_m2)) return;
  c.height_m = (variance * c.height_m + c.variance_m2 * p.z_m) / (variance + c.variance_m2);
  c.variance_m2 = std::max(
      variance * c.variance_m2 / (variance + c.variance_m2),
      static_cast<float>(parameters_.min_variance_m2));
  c.stamp_s = stamp_s;
}

void HighestPointMap::update(const Frame& frame)
{
  const Window window =
      window_around(parameters_, pose_of_base(frame.T_map_sensor, frame.T_base_sensor));
  if (window.min_cell_x != window_.min_cell_x || window.min_cell_y != window_.min_cell_y ||
      cells_.empty())
    move_to(window);
  const auto points = accepted_points(frame, parameters_);
  for (const MapPoint& p : points)
  {
    const int i = cell_index(window_, p.x_m, p.y_m);
    if (i >= 0) fuse(cells_[static_cast<std::size_t>(i)], p, frame.stamp_s);
  }
  if (frame.stamp_s - last_cleanup_s_ < kCleanupPeriod_s) return;
  clean_up(frame, points);
  last_cleanup_s_ = frame.stamp_s;
}

void HighestPointMap::clean_up(const Frame& frame, const std::vector<MapPoint>& points)
{
  std::vector<float> lowest(cells_.size(), kNan), bound(cells_.size(), kNan);
  for (const MapPoint& p : points)
  {
    const int i = cell_index(window_, p.x_m, p.y_m);
    if (i < 0) continue;
    float& z = lowest[static_cast<std::size_t>(i)];
    z = std::fmin(z, p.z_m);
  }
  for (int iy = 0; iy < window_.cells; ++iy)
    for (int ix = 0; ix < window_.cells; ++ix)
    {
      const float z = lowest[static_cast<std::size_t>(iy * window_.cells + ix)];
      if (!std::isnan(z)) lower_bounds_along(frame.T_map_sensor, ix, iy, z, bound);
    }
  for (std::size_t i = 0; i < cells_.size(); ++i)
  {
    Cell& c = cells_[i];
    const float low = c.height_m - kCleanupDeviations * std::sqrt(c.variance_m2);
    if (c.stamp_s < frame.stamp_s && low > bound[i]) c = {kNan, kNan, 0.0};
  }
}

/** Walks from the sensor's cell towards a cell; the ray bounds the heights of all cells before it.
 */
void HighestPointMap::lower_bounds_along(
    const Pose& from, int to_ix, int to_iy, float to_z_m, std::vector<float>& bound_m) const
{
  const int n = window_.cells;
  const auto cell_of = [&](double at_m, std::int64_t min_cell)
  { return std::floor(at_m / window_.resolution_m) - static_cast<double>(min_cell); };
  const double from_x = cell_of(from.x(), window_.min_cell_x);
  const double from_y = cell_of(from.y(), window_.min_cell_y);
  const double dx = to_ix - from_x, dy = to_iy - from_y;
  const int steps = static_cast<int>(std::max(std::abs(dx), std::abs(dy)));
  for (int s = 1; s < steps; ++s)
  {
    const double t = static_cast<double>(s) / steps;
    const auto ix = static_cast<int>(std::lround(from_x + t * dx));
    const auto iy = static_cast<int>(std::lround(from_y + t * dy));
    if (ix < 0 || iy < 0 || ix >= n || iy >= n) continue;  // the sensor is outside
    float& bound = bound_m[static_cast<std::size_t>(iy * n + ix)];
    bound = std::fmin(bound, static_cast<float>(from.z() + t * (to_z_m - from.z())));
  }
}

Surfaces HighestPointMap::read()
{
  Surfaces s(window_);
  for (std::size_t i = 0; i < cells_.size(); ++i)
  {
    if (std::isnan(cells_[i].height_m)) continue;
    s.elevation_m[i] = s.ground_m[i] = cells_[i].height_m;
    s.state[i] = static_cast<std::uint8_t>(CellState::Measured);
  }
  judge_one_surface(s, parameters_);
  return s;
}

}  // namespace talus::baselines
