#include "view_ahead.h"

#include <algorithm>
#include <cmath>

namespace talus::nav
{
hints::HighestRay highest_ray(const sim::Scanner& scanner, const Pose& T_base_sensor)
{
  double slope = -HUGE_VAL;
  for (const double elevation : scanner.elevations_rad)
  {
    const sim::Vec3 d = sim::rotate(T_base_sensor, {std::cos(elevation), 0, std::sin(elevation)});
    if (d.x > 0) slope = std::max(slope, d.z / std::hypot(d.x, d.y));
  }
  return {T_base_sensor.x(), T_base_sensor.z(), slope};
}

}  // namespace talus::nav
