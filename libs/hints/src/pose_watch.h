#pragma once
#include <talus/frame.h>

#include <cstddef>

#include "base_points.h"

namespace talus::hints
{
/** Looks for poses that leap: off from where the motion so far leads, faster than anything can. */
class PoseWatch
{
 public:
  void add(double stamp_s, const Pose& T_map_base);

  std::size_t jumps() const { return jumps_; }
  /// @name Of the largest jump
  /// @{
  double jump_stamp_s() const { return stamp_s_; }
  double jump_m() const { return jump_m_; }
  double jump_deg() const { return jump_deg_; }
  /// @}

 private:
  struct Step
  {
    double duration_s = 0;
    Vec3 moved_m;
    double turned_rad = 0;
  };
  void judge(const Step& step, double stamp_s);

  bool has_pose_ = false, has_step_ = false, has_jumped_ = false;
  double last_s_ = 0;
  Pose last_;
  Step step_;
  std::size_t jumps_ = 0;
  double stamp_s_ = 0, jump_m_ = 0, jump_deg_ = 0;
};

}  // namespace talus::hints
