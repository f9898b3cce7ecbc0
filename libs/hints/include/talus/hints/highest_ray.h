#pragma once
#include <optional>
#include <string>

namespace talus::hints
{
/** The highest ray that a sensor sends straight ahead, over level ground. Lower rays see what lies
 * below it, and nothing sees what lies above. */
struct HighestRay
{
  double ahead_m = 0;  //!< of the sensor, before the base
  double sensor_m = 0;  //!< height of the sensor above the ground
  double slope = 0;  //!< by which the ray rises in each metre; below 0: it looks down

  /** Of the ray above the ground, so far ahead of the base. */
  double height_m(double from_base_m) const;
};

/** Where ahead of the base something of that height is seen: "from 0.5 m on", "up to 3.2 m",
 * "everywhere" or "nowhere". */
std::string seen_ahead(const HighestRay& ray, double height_m);

/** What a robot of that height [m] does not see ahead of itself, for a person. Nothing where the
 * highest ray looks up, or is as high as the robot 1 m ahead. */
std::optional<std::string> unseen_ahead(const HighestRay& ray, double clearance_m);

}  // namespace talus::hints
