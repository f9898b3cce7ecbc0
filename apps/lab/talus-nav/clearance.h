#pragma once
#include "simulated_robot.h"

#include <mrpt/maps/CSimplePointsMap.h>

namespace talus::nav
{
/** What the outline of the robot keeps away from all that it knows to be blocked. */
constexpr double kKeepAway_m = 0.1;

/** How long [s] a robot may go on with these speeds, at most `most_s`: until one of the points
 * (robot frame, seen from above) is nearer to its outline than kKeepAway_m. A robot that stands
 * nearer to one already must not come nearer than that to any. */
double clear_time_s(
    const mrpt::maps::CSimplePointsMap& points, const RobotBody& body, double v_mps, double w_radps,
    double most_s);

}  // namespace talus::nav
