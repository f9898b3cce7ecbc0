#pragma once
#include "lattice.h"

#include <vector>

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

}  // namespace talus::nav
