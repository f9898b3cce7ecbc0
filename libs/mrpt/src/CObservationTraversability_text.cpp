#include <mrpt/core/format.h>
#include <talus/mrpt/CObservationTraversability.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>

namespace talus
{
namespace
{
using Summary = CObservationTraversability::Summary;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void count_states(const std::vector<float>& state, Summary& s)
{
  for (const float v : state)
  {
    s.measured += v == static_cast<float>(CellState::Measured);
    s.filled_two_sided += v == static_cast<float>(CellState::FilledTwoSided);
    s.filled_one_sided += v == static_cast<float>(CellState::FilledOneSided);
  }
}

/** Distances to the blocked cells, in the frame of the base seen from above. */
void find_nearest(
    const CObservationTraversability& obs, const std::vector<float>& traversability, Summary& s)
{
  const Window& w = obs.window;
  const double c = std::cos(obs.T_map_base.yaw()), n = std::sin(obs.T_map_base.yaw());
  double nearest2 = std::numeric_limits<double>::infinity(), ahead = nearest2;
  for (std::size_t i = 0; i < traversability.size(); i++)
  {
    if (traversability[i] != 0.0F) continue;
    const auto cells = static_cast<std::size_t>(w.cells);
    const double x_map = w.min_x_m() + (static_cast<double>(i % cells) + 0.5) * w.resolution_m;
    const double y_map = w.min_y_m() + (static_cast<double>(i / cells) + 0.5) * w.resolution_m;
    const double dx = x_map - obs.T_map_base.x(), dy = y_map - obs.T_map_base.y();
    const double x = c * dx + n * dy, y = -n * dx + c * dy;
    if (x * x + y * y < nearest2)
    {
      nearest2 = x * x + y * y;
      s.nearest_rad = std::atan2(y, x);
    }
    if (x > 0 && std::abs(y) <= CObservationTraversability::kHalfCorridor_m)
      ahead = std::min(ahead, x);
  }
  if (std::isfinite(nearest2)) s.nearest_m = std::sqrt(nearest2);
  if (std::isfinite(ahead)) s.ahead_m = ahead;
}
}  // namespace

Summary CObservationTraversability::summary() const
{
  Summary s;
  s.nearest_m = s.nearest_rad = s.ahead_m = s.min_ground_m = s.max_ground_m = kNan;
  const auto& traversability = layer(Layer::Traversability);
  count_states(layer(Layer::State), s);
  for (const float v : traversability)
  {
    s.free += v > 0;
    s.blocked += v == 0;
  }
  for (const float z : layer(Layer::GroundElevation))
    if (!std::isnan(z))
    {
      s.min_ground_m = std::fmin(s.min_ground_m, z);
      s.max_ground_m = std::fmax(s.max_ground_m, z);
    }
  find_nearest(*this, traversability, s);
  const double all = std::max(1.0, static_cast<double>(window.cells) * window.cells);
  for (double* part : {&s.measured, &s.filled_two_sided, &s.filled_one_sided, &s.free, &s.blocked})
    *part /= all;
  s.unknown = 1 - s.free - s.blocked;
  return s;
}

void CObservationTraversability::getDescriptionAsText(std::ostream& o) const
{
  CObservation::getDescriptionAsText(o);
  const Summary s = summary();
  std::string names;
  for (std::size_t i = 0; i < kLayerCount; i++)
    if (!layers[i].empty()) names += std::string(names.empty() ? "" : ", ") + kLayerNames[i];
  o << "Robot in the map      : " << T_map_base.asString() << "\n"
    << "Sensor on the robot   : " << T_base_sensor.asString() << "\n"
    << mrpt::format(
           "Window                : %d x %d cells of %g m from (%.2f, %.2f)\n", window.cells,
           window.cells, window.resolution_m, window.min_x_m(), window.min_y_m())
    << "Layers                : " << names << "\n"
    << mrpt::format(
           "Ground                : %.1f %% measured, %.1f %% filled from two sides, %.1f %% from "
           "one; %.2f to %.2f m\n",
           100 * s.measured, 100 * s.filled_two_sided, 100 * s.filled_one_sided, s.min_ground_m,
           s.max_ground_m)
    << mrpt::format(
           "Traversability        : %.1f %% free, %.1f %% blocked, %.1f %% unknown\n", 100 * s.free,
           100 * s.blocked, 100 * s.unknown)
    << mrpt::format(
           "Nearest blocked cell  : %.2f m at %.0f deg; ahead %.2f m\n", s.nearest_m,
           s.nearest_rad * 180 / M_PI, s.ahead_m);
}

std::string CObservationTraversability::exportTxtHeader() const
{
  std::string text;
  for (const char* column :
       {"x_m", "y_m", "z_m", "yaw_rad", "pitch_rad", "roll_rad", "coverage", "measured",
        "two_sided", "one_sided", "free", "blocked", "unknown", "nearest_m", "nearest_rad",
        "ahead_m", "ground_min_m", "ground_max_m"})
    text += mrpt::format("%13s ", column);
  return text;
}

std::string CObservationTraversability::exportTxtDataRow() const
{
  const Summary s = summary();
  std::string text;
  for (const double v :
       {T_map_base.x(), T_map_base.y(), T_map_base.z(), T_map_base.yaw(), T_map_base.pitch(),
        T_map_base.roll(), s.coverage(), s.measured, s.filled_two_sided, s.filled_one_sided, s.free,
        s.blocked, s.unknown, s.nearest_m, s.nearest_rad, s.ahead_m, s.min_ground_m,
        s.max_ground_m})
    text += mrpt::format("%13.6f ", v);
  return text;
}

}  // namespace talus
