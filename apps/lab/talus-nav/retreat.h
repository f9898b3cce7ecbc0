#pragma once
#include <mrpt/math/TPoint2D.h>

#include <optional>
#include <vector>

namespace talus::nav
{
/** Takes a robot that stands, although there is a way, back along its own trail. What blocks it may
 * be something that left while it was below the beams of the scanner, and from farther back the map
 * sees that it is gone. */
class Retreat
{
 public:
  /** Where to go back to, in the frame of `at`, or nothing: go on. To be asked at each step in
   * which the robot has somewhere to go. */
  std::optional<mrpt::math::TPoint2D> target(double time_s, const mrpt::math::TPoint2D& at);

  /** The robot has nowhere to go: it is right to stand. */
  void rest(double time_s) { stands_since_s_ = time_s; }

 private:
  void follow(double time_s, const mrpt::math::TPoint2D& at);
  std::optional<mrpt::math::TPoint2D> place_behind(const mrpt::math::TPoint2D& at) const;

  std::vector<mrpt::math::TPoint2D> trail_;
  mrpt::math::TPoint2D stands_at_{1e9, 1e9};
  double stands_since_s_ = 0, give_up_s_ = 0;
  std::optional<mrpt::math::TPoint2D> going_back_to_;
};

}  // namespace talus::nav
