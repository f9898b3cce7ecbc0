#pragma once
#include <talus/hints/highest_ray.h>
#include <talus/sim/scanner.h>

namespace talus::nav
{
/** Of a scanner that is mounted like that, on a base that stands on level ground. */
hints::HighestRay highest_ray(const sim::Scanner& scanner, const Pose& T_base_sensor);

}  // namespace talus::nav
