#include <talus/baselines/cell_line.h>
#include <talus/baselines/one_surface_map.h>

#include <algorithm>
#include <cmath>

#include "nan.h"

namespace talus::baselines
{
namespace
{
constexpr float kCleanupDeviations = 3.0f;

/** Height below which the rays to the lowest points of all cells passed; NaN: none did. */
std::vector<float> ray_bounds(
    const Window& window, const Pose& T_map_sensor, const std::vector<MapPoint>& points)
{
  const auto n = static_cast<std::size_t>(window.cells) * static_cast<std::size_t>(window.cells);
  std::vector<float> lowest(n, kNan), bound(n, kNan);
  for (const MapPoint& p : points)
  {
    const int i = cell_index(window, p.x_m, p.y_m);
    if (i < 0) continue;
    float& z = lowest[static_cast<std::size_t>(i)];
    z = std::fmin(z, p.z_m);
  }
  for (std::size_t i = 0; i < n; ++i)
  {
    if (std::isnan(lowest[i])) continue;
    const int cell = static_cast<int>(i);
    const CellLine line(window, T_map_sensor, cell % window.cells, cell / window.cells);
    for (int s = 1; s < line.steps(); ++s)
    {
      const int at = line(s);
      if (at < 0) continue;  // the sensor is outside
      const double t = static_cast<double>(s) / line.steps();
      const double z_m = T_map_sensor.z() + t * (lowest[i] - T_map_sensor.z());
      float& b = bound[static_cast<std::size_t>(at)];
      b = std::fmin(b, static_cast<float>(z_m));
    }
  }
  return bound;
}

}  // namespace

void OneSurfaceMap::roll_to(const Frame& frame)
{
  cells_.move_to(window_around(parameters_, pose_of_base(frame.T_map_sensor, frame.T_base_sensor)));
}

float OneSurfaceMap::point_variance_m2(const MapPoint& p) const
{
  const auto deviation = static_cast<float>(parameters_.c_beam_m + parameters_.a_beam * p.range_m);
  return deviation * deviation;
}

void OneSurfaceMap::kalman(Cell& c, const MapPoint& p, double stamp_s) const
{
  const float variance = point_variance_m2(p);
  c.height_m = (variance * c.height_m + c.variance_m2 * p.z_m) / (variance + c.variance_m2);
  c.variance_m2 = std::max(
      variance * c.variance_m2 / (variance + c.variance_m2),
      static_cast<float>(parameters_.min_variance_m2));
  c.stamp_s = stamp_s;
}

void OneSurfaceMap::clean_up(const Frame& frame, const std::vector<MapPoint>& points)
{
  const std::vector<float> bound = ray_bounds(cells_.window(), frame.T_map_sensor, points);
  for (std::size_t i = 0; i < cells_.size(); ++i)
  {
    Cell& c = cells_[i];
    const float low = c.height_m - kCleanupDeviations * std::sqrt(c.variance_m2);
    if (c.stamp_s < frame.stamp_s && low > bound[i]) c = {};
  }
}

Surfaces OneSurfaceMap::surfaces() const
{
  Surfaces s(cells_.window());
  for (std::size_t i = 0; i < cells_.size(); ++i)
  {
    if (!cells_[i].known()) continue;
    s.elevation_m[i] = s.ground_m[i] = cells_[i].height_m;
    s.state[i] = static_cast<std::uint8_t>(CellState::Measured);
  }
  return s;
}

}  // namespace talus::baselines
