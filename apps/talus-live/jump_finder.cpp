#include "jump_finder.h"

namespace talus::app
{
/** Where it begins anew, the map takes it up where it was: then nothing has jumped. */
bool JumpFinder::odometry_goes_on(const import::StreamPose& pose)
{
  constexpr double kMaxFaster = 2;
  const io::Trajectory::Entry now{pose.time_s, (-pose.T_map_odom) + pose.T_map_base};
  const double step_m = odometry_ ? odometry_->T_map_base.distanceTo(now.T_map_base) : 0;
  const double speed_mps = odometry_ ? step_m / (now.time_s - odometry_->time_s) : 0;
  const bool goes_on = step_m <= min_m_ || speed_mps <= kMaxFaster * speed_mps_;
  odometry_ = now;
  speed_mps_ = speed_mps;
  return goes_on;
}

std::vector<Jump> JumpFinder::add(const std::vector<import::StreamPose>& poses)
{
  std::vector<Jump> jumps;
  for (const auto& pose : poses)
    if (const auto jump = jump_before(pose)) jumps.push_back(*jump);
  return jumps;
}

std::optional<Jump> JumpFinder::jump_before(const import::StreamPose& pose)
{
  constexpr double kMoment_s = 0.25;  // within which TF may go from one to the other
  const bool goes_on = odometry_goes_on(pose);
  if (!settled_ || !goes_on) settled_ = pose;
  const auto T = pose.T_map_odom + (-settled_->T_map_odom);
  const bool has_jumped = ((-T) + pose.T_map_base).distanceTo(pose.T_map_base) > min_m_;
  if (has_jumped || pose.time_s - settled_->time_s > kMoment_s) settled_ = pose;
  return has_jumped ? std::optional<Jump>({pose.time_s, T}) : std::nullopt;
}

}  // namespace talus::app
