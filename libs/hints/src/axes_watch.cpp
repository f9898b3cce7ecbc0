#include "axes_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kStep_m = 0.2;  // of a direction of travel
constexpr double kKeptStep_m = 0.8, kKeptTurn_rad = 0.3;  // between frames that are kept
constexpr std::size_t kMaxFrames = 24, kMaxStraight = 12;  // the others are for turns
constexpr double kSameWalls_m = 4;  // frames that see the same walls
}  // namespace

bool AxesWatch::wants(const Pose& T_map_base)
{
  const double heading = std::atan2(T_map_base.m[4], T_map_base.m[0]);
  if (!step_begin_) step_begin_ = T_map_base;
  const double x = T_map_base.x() - step_begin_->x(), y = T_map_base.y() - step_begin_->y();
  if (const double moved_m = std::hypot(x, y); moved_m >= kStep_m)
  {
    const double middle = std::atan2(step_begin_->m[4], step_begin_->m[0]);
    const double off = std::atan2(y, x) - middle - std::remainder(heading - middle, 2 * M_PI) / 2;
    path_m_ += moved_m;
    cos_sum_ += moved_m * std::cos(2 * off);
    sin_sum_ += moved_m * std::sin(2 * off);
    step_begin_ = T_map_base;
  }
  if (kept_.size() >= kMaxFrames) return false;
  if (!kept_.empty())
  {
    const Kept& last = kept_.back();
    const bool turned = std::abs(std::remainder(heading - last.heading_rad, 2 * M_PI)) > kKeptTurn_rad;
    const bool moved = std::hypot(T_map_base.x() - last.x_m, T_map_base.y() - last.y_m) > kKeptStep_m;
    if (!turned && !(moved && kept_.size() < kMaxStraight)) return false;
  }
  kept_.push_back({T_map_base.x(), T_map_base.y(), heading, {}});
  return true;
}

std::optional<double> AxesWatch::sideways_rad() const
{
  const double always = std::hypot(cos_sum_, sin_sum_);
  if (path_m_ < kMinSidewaysPath_m || always < kAlwaysSideways * path_m_) return {};
  return std::atan2(sin_sum_, cos_sum_) / 2;
}

const std::vector<AxesWatch::Change>& AxesWatch::changes()
{
  static const std::vector<Change> all{
      {"as given", false, false, false, 0},
      {"y of the poses is mirrored", true, false, false, 0},
      {"y and yaw of the poses are mirrored (or y of the points)", true, true, false, 0},
      {"the yaw of the poses is mirrored", false, true, false, 0},
      {"x and y of the poses are swapped", false, false, true, 0},
      {"the sensor is turned by +90 degrees of yaw", false, false, false, M_PI / 2},
      {"the sensor is turned by -90 degrees of yaw", false, false, false, -M_PI / 2},
      {"the sensor is turned by 180 degrees of yaw", false, false, false, M_PI}};
  return all;
}

bool AxesWatch::are_compared(const Kept& a, const Kept& b) const
{
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) < kSameWalls_m;
}

double AxesWatch::apart_m(const Change& c) const
{
  std::vector<std::vector<WallLine>> lines;
  for (const Kept& k : kept_)
  {
    const double x = c.swaps ? k.y_m : k.x_m, y = c.swaps ? k.x_m : k.y_m;
    const double heading = (c.mirrors_yaw ? -1 : 1) * k.heading_rad + c.turn_rad;
    lines.emplace_back();
    for (const Facet& f : k.facets)
      lines.back().push_back(wall_line(f, x, c.mirrors_y ? -y : y, heading));
  }
  WallsApart apart;
  for (std::size_t i = 0; i < kept_.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (are_compared(kept_[i], kept_[k])) apart.add(lines[i], lines[k]);
  return apart.mean_m();
}

std::optional<AxesWatch::Fit> AxesWatch::better_axes() const
{
  Fit fit{apart_m(changes().front()), HUGE_VAL, ""};
  if (!(fit.given_m > kMinWrongAxes_m)) return {};
  for (const Change& change : changes())
    if (const double m = apart_m(change); m < fit.best_m)
    {
      fit.best_m = m;
      fit.change = change.text;
    }
  if (fit.best_m > kAxesFit * fit.given_m) return {};
  return fit;
}

}  // namespace talus::hints
