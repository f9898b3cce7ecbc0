#pragma once
#include <mrpt/math/TPoint2D.h>

#include <optional>
#include <vector>

#include "lattice.h"

namespace talus::nav
{
/** Speeds of a robot. */
struct Speeds
{
  double v_mps, w_radps;
};

/** Where on a way a robot is: the place nearest to it. */
std::size_t nearest_on(const std::vector<RoutePose>& way, const mrpt::math::TPose2D& robot);

/** Whether a way is narrow or leads backwards within `ahead_m`. */
bool is_narrow(const std::vector<RoutePose>& way, const mrpt::math::TPose2D& robot, double ahead_m);
/** Whether it leads over ground on which the heading matters. */
bool is_tilted(const std::vector<RoutePose>& way, const mrpt::math::TPose2D& robot, double ahead_m);

/** Drives slowly along a way and turns on the spot where it does, without a look at obstacles. */
class Follower
{
 public:
  Speeds follow(const std::vector<RoutePose>& way, const mrpt::math::TPose2D& robot);

 private:
  bool turns_ = false;
};

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
