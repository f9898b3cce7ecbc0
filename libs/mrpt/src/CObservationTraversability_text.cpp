#include <mrpt/core/format.h>
#include <talus/mrpt/CObservationTraversability.h>
#include <talus/number_text.h>

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

std::string percent(double part) { return fixed_text(100 * part, 1) + " %"; }

void count_states(const float* state, std::size_t count, Summary& s)
{
  for (std::size_t i = 0; i < count; i++)
  {
    s.measured += state[i] == static_cast<float>(CellState::Measured);
    s.filled_two_sided += state[i] == static_cast<float>(CellState::FilledTwoSided);
    s.filled_one_sided += state[i] == static_cast<float>(CellState::FilledOneSided);
    s.presumed += state[i] == static_cast<float>(CellState::Presumed);
  }
}

/** Finds the blocked cells nearest to the base, in its frame seen from above. */
class NearestBlocked
{
 public:
  NearestBlocked(const Window& window, const mrpt::poses::CPose3D& T_map_base)
      : w_(window),
        base_(T_map_base),
        cos_(std::cos(T_map_base.yaw())),
        sin_(std::sin(T_map_base.yaw()))
  {
  }

  void take(std::size_t cell)
  {
    const auto cells = static_cast<std::size_t>(w_.cells);
    const double x_map = w_.min_x_m() + (static_cast<double>(cell % cells) + 0.5) * w_.resolution_m;
    const double y_map = w_.min_y_m() + (static_cast<double>(cell / cells) + 0.5) * w_.resolution_m;
    const double dx = x_map - base_.x(), dy = y_map - base_.y();
    const double x = cos_ * dx + sin_ * dy, y = -sin_ * dx + cos_ * dy;
    if (x * x + y * y < nearest2_)
    {
      nearest2_ = x * x + y * y;
      nearest_rad_ = std::atan2(y, x);
    }
    if (x > 0 && std::abs(y) <= CObservationTraversability::kHalfCorridor_m)
      ahead_m_ = std::min(ahead_m_, x);
  }

  void write_to(Summary& s) const
  {
    s.nearest_rad = nearest_rad_;
    if (std::isfinite(nearest2_)) s.nearest_m = std::sqrt(nearest2_);
    if (std::isfinite(ahead_m_)) s.ahead_m = ahead_m_;
  }

 private:
  const Window& w_;
  const mrpt::poses::CPose3D& base_;
  double cos_, sin_;
  double nearest2_ = std::numeric_limits<double>::infinity(), ahead_m_ = nearest2_;
  double nearest_rad_ = kNan;
};
}  // namespace

Summary CObservationTraversability::summary() const
{
  requireSound();
  Summary s;
  s.nearest_m = s.nearest_rad = s.ahead_m = s.min_ground_m = s.max_ground_m = kNan;
  forEachValue(Layer::State, [&](const float* v, std::size_t count) { count_states(v, count, s); });
  NearestBlocked nearest(window, T_map_base);
  std::size_t cell = 0;
  forEachValue(
      Layer::Traversability,
      [&](const float* v, std::size_t count)
      {
        for (std::size_t i = 0; i < count; i++, cell++)
        {
          s.free += v[i] > 0;
          s.blocked += v[i] == 0;
          if (v[i] == 0) nearest.take(cell);
        }
      });
  nearest.write_to(s);
  forEachValue(
      Layer::GroundElevation,
      [&](const float* v, std::size_t count)
      {
        for (std::size_t i = 0; i < count; i++)
        {
          if (std::isnan(v[i])) continue;
          s.min_ground_m = std::fmin(s.min_ground_m, v[i]);
          s.max_ground_m = std::fmax(s.max_ground_m, v[i]);
        }
      });
  const double all = std::max(1.0, static_cast<double>(window.cells) * window.cells);
  for (double* part :
       {&s.measured, &s.filled_two_sided, &s.filled_one_sided, &s.presumed, &s.free, &s.blocked})
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
    if (has_layer(static_cast<Layer>(i)))
      names += std::string(names.empty() ? "" : ", ") + kLayerTable[i].name;
  o << "Robot in the map      : " << T_map_base.asString() << "\n"
    << "Sensor on the robot   : " << T_base_sensor.asString() << "\n"
    << "Window                : " << window.cells << " x " << window.cells << " cells of "
    << number_text(window.resolution_m, 6) << " m from (" << fixed_text(window.min_x_m(), 2) << ","
    << fixed_text(window.min_y_m(), 2) << ")\n"
    << "Layers                : " << names << "\n"
    << "Ground                : " << percent(s.measured) << " measured, "
    << percent(s.filled_two_sided) << " filled from two sides, " << percent(s.filled_one_sided)
    << " from one, " << percent(s.presumed) << " presumed; " << fixed_text(s.min_ground_m, 2)
    << " to " << fixed_text(s.max_ground_m, 2) << " m\n"
    << "Traversability        : " << percent(s.free) << " free, " << percent(s.blocked)
    << " blocked, " << percent(s.unknown) << " unknown\n"
    << "Nearest blocked cell  : " << fixed_text(s.nearest_m, 2) << " m at "
    << fixed_text(s.nearest_rad * 180 / M_PI, 0) << " deg; ahead " << fixed_text(s.ahead_m, 2)
    << " m\n";
}

std::string CObservationTraversability::exportTxtHeader() const
{
  std::string text;
  for (const char* column :
       {"x_m", "y_m", "z_m", "yaw_rad", "pitch_rad", "roll_rad", "coverage", "measured",
        "two_sided", "one_sided", "presumed", "free", "blocked", "unknown", "nearest_m",
        "nearest_rad", "ahead_m", "ground_min_m", "ground_max_m"})
    text += mrpt::format("%13s ", column);
  return text;
}

std::string CObservationTraversability::exportTxtDataRow() const
{
  const Summary s = summary();
  std::string text;
  for (const double v :
       {T_map_base.x(), T_map_base.y(), T_map_base.z(), T_map_base.yaw(), T_map_base.pitch(),
        T_map_base.roll(), s.coverage(), s.measured, s.filled_two_sided, s.filled_one_sided,
        s.presumed, s.free, s.blocked, s.unknown, s.nearest_m, s.nearest_rad, s.ahead_m,
        s.min_ground_m, s.max_ground_m})
    text += mrpt::format("%13s ", fixed_text(v, 6).c_str());
  return text;
}

}  // namespace talus
