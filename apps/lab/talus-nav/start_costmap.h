#pragma once
#include <talus/nav/costmap.h>
#include <talus/sim/world.h>

namespace talus::nav
{
constexpr double kFarthest_m = 3000;  //!< from the origin: what OctoMap can hold

/** Covers start, goal and all that stands in the world, and is unknown. Throws
 * std::invalid_argument where that is too far away or too large. */
Costmap start_costmap(
    const sim::World& world, const Point2& start, const Point2& goal, double resolution_m);

}  // namespace talus::nav
