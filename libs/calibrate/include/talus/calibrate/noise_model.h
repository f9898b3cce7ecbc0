#pragma once
#include <string>

namespace talus::calibrate
{
/** How far a point is from the ground it was measured on, by eq. 2-4:
 * (c + a l)^2 p^2 + (lambda_t l sin(theta/2))^2 + ground^2 [m^2], l the range. */
struct NoiseModel
{
  /** Where the sensor's error goes. Along the beam (a range finder): p is the cosine of the angle
   * between beam and normal, a grazing beam hardly errs in height. Else p = 1: the error in height
   * itself, as the map reads eq. 2. */
  bool along_beam = true;
  double c_beam_m = 0.01, a_beam = 0.001, lambda_t = 0;
  /** Roughness of the ground below the size of a patch [m]; part of c_beam when not along_beam. */
  double ground_m = 0;

  /** `cosine`: between beam and normal, `half_turn`: sin(theta/2). */
  double variance_m2(double range_m, double cosine, double half_turn) const;
};

/** A constant deviation whatever the range: for the first rounds. */
NoiseModel uniform_noise(double deviation_m);

}  // namespace talus::calibrate
