#include "pose_watch.h"

#include <algorithm>
#include <cmath>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kMinStep_s = 0.02;  // frames of several sensors come close upon each other

/** Angle between two attitudes. */
double turn_rad(const Pose& a, const Pose& b)
{
  double trace = 0;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t k = 0; k < 3; ++k) trace += a.m[4 * row + k] * b.m[4 * row + k];
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0));
}
}  // namespace

void PoseWatch::add(double stamp_s, const Pose& T_map_base)
{
  const double duration_s = stamp_s - last_s_;
  if (has_pose_ && duration_s >= 0 && duration_s < kMinStep_s) return;
  const bool follows = has_pose_ && duration_s > 0 && duration_s <= kJumpGap_s;
  if (follows)
  {
    const Step step{
        duration_s, origin_of(T_map_base) - origin_of(last_), turn_rad(last_, T_map_base)};
    if (has_step_) judge(step, stamp_s);
    step_ = step;
  }
  has_step_ = follows;
  has_pose_ = true;
  last_s_ = stamp_s;
  last_ = T_map_base;
}

void PoseWatch::judge(const Step& step, double stamp_s)
{
  const double ratio = step.duration_s / step_.duration_s;
  const Vec3 off{
      step.moved_m.x - ratio * step_.moved_m.x, step.moved_m.y - ratio * step_.moved_m.y,
      step.moved_m.z - ratio * step_.moved_m.z};
  const double off_m = length(off);
  const double off_deg = std::abs(step.turned_rad - ratio * step_.turned_rad) * 180 / M_PI;
  const double square_s2 = step.duration_s * step.duration_s;
  const bool leaps = off_m > std::max(kJump_m, kJump_mps2 * square_s2) ||
                     std::abs(off.z) > std::max(kJump_m, kJumpUp_mps2 * square_s2) ||
                     (off_deg > kTurn_deg && step.duration_s <= kTurnGap_s);
  const bool is_its_end = leaps && has_jumped_;  // the speed drops again
  has_jumped_ = leaps && !is_its_end;
  if (!has_jumped_) return;
  ++jumps_;
  if (jumps_ > 1 && off_m < jump_m_) return;
  stamp_s_ = stamp_s;
  jump_m_ = off_m;
  jump_deg_ = off_deg;
}

}  // namespace talus::hints
