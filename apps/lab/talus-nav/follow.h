#pragma once
#include "map_source.h"
#include "simulated_robot.h"

#include <talus/nav/route.h>

#include <vector>

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

/** What the outline of the robot keeps away from what it knows to be blocked. */
constexpr double kKeepAway_m = 0.1;
/** And from what stands there, where there is no room. */
constexpr double kKeepAwayWhereNarrow_m = 0.02;

/** How long [s] a robot may go on with these speeds, at most `max_s`: until one of the places is
 * nearer to its outline than kKeepAway_m, or where it is `narrow` and no edge than
 * kKeepAwayWhereNarrow_m. One that is nearer already, or over an edge, must not come nearer to it.
 */
double clear_time_s(
    const std::vector<BlockedPlace>& places, const RobotBody& body, double v_mps, double w_radps,
    double max_s, bool narrow);

}  // namespace talus::nav
