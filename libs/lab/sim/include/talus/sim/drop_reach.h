#pragma once
#include <talus/sim/scanner.h>

namespace talus::sim
{
/** How a robot stops, and where it is in front of its base. */
struct Stopping
{
  double reaction_s = 0.4;  //!< from the sweep that shows why to the brakes
  double deceleration_mps2 = 1.0;  //!< > 0
  double front_m = 0.3;  //!< of its body, before the base

  /** Way that it needs from a speed [m]. */
  double way_m(double speed_mps) const
  {
    return speed_mps * reaction_s + speed_mps * speed_mps / (2 * deceleration_mps2);
  }
};

/** A hole in level ground is found when a ray of a sweep passes kFound_m or more below its near
 * edge, straight ahead. */
constexpr double kFound_m = 0.05;

/** The least width [m], along the way, of a hole that a robot which drives straight at it finds in
 * time to stop before it, however the sweeps fall; infinite where no ray meets the ground far
 * enough ahead. `T_base_sensor`: the base is on the ground. */
double narrowest_hole_m(
    const Scanner& scanner, const Pose& T_base_sensor, double speed_mps, const Stopping& stopping);

/** The greatest speed [m/s], to a hundredth and up to 20, at which it finds each hole of this width
 * in time; 0: at none. */
double fastest_before_hole_mps(
    const Scanner& scanner, const Pose& T_base_sensor, double width_m, const Stopping& stopping);

/** Where the ray straight ahead that looks down most steeply meets level ground, from the base
 * [m]; infinite where none does. */
double nearest_ground_m(const Scanner& scanner, const Pose& T_base_sensor);

}  // namespace talus::sim
