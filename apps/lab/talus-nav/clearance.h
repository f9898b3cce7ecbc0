#pragma once
#include "map_source.h"
#include "simulated_robot.h"

#include <vector>

namespace talus::nav
{
/** What the outline of the robot keeps away from what it knows to be blocked. */
constexpr double kKeepAway_m = 0.1;
/** And from what stands there, where there is no room. */
constexpr double kKeepAwayWhereNarrow_m = 0.02;

/** How long [s] a robot may go on with these speeds, at most `most_s`: until one of the places is
 * nearer to its outline than kKeepAway_m, or where it is `narrow` and no edge than
 * kKeepAwayWhereNarrow_m. A robot that stands nearer to one already must not come nearer than that
 * to any. */
double clear_time_s(
    const std::vector<BlockedPlace>& places, const RobotBody& body, double v_mps, double w_radps,
    double most_s, bool narrow);

}  // namespace talus::nav
