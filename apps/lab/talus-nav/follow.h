#pragma once
#include <talus/nav/route.h>

namespace talus::nav
{
/** Speeds of a robot. */
struct Speeds
{
  double v_mps, w_radps;
};

/** Whether a route is narrow or leads backwards within `ahead_m`. */
bool is_narrow(const Route& route, const Pose2& robot, double ahead_m);
/** Whether it leads over ground on which the heading matters. */
bool is_tilted(const Route& route, const Pose2& robot, double ahead_m);

/** Drives slowly along a route and turns on the spot where it does, without a look at obstacles. */
class Follower
{
 public:
  Speeds follow(const Route& route, const Pose2& robot);

 private:
  bool turns_ = false;
};

}  // namespace talus::nav
