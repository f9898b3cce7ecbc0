#pragma once
#include <talus/calibrate/associate.h>

namespace talus::calibrate
{
/** The robust loss, in deviations: Cauchy's rho(s) = a^2 log(1 + s / a^2) of the squared residual
 * s.
 */
constexpr double kLoss = 3.0;

/** What the points say about the parameters once the planes, which are estimated together with
 * them, are eliminated (Schur complement). */
struct Information
{
  Matrix normal = Matrix::Zero();  //!< J^T W J
  /** The part of `normal` that is there only because the planes' slopes err: on a level floor noise
   * tilts each plane a little, and a tilted plane seems to determine x, y and yaw. */
  Matrix feigned = Matrix::Zero();
  /** Covariance of the gradient, from how the gradients of patches and of stretches of time differ
   * (clusters both ways): counts errors that points share, of the poses or of ground that is not
   * flat. */
  Matrix gradient = Matrix::Zero();
  double variance_factor = 1;  //!< mean weighted square of the residuals: 1 if the noise model fits
};
Information gather_information(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Association& a);

/** Covariance of the chosen parameters, zero rows and columns for the others. */
Matrix covariance_of(const Information& info, const Choice& chosen);

/** Which of the wanted parameters the log constrains. The weakest direction is sought until none is
 * weak: one along which the answer would be no better than useful_sigma, or would come from noise
 * in the planes. Of the parameters that share it the one is given up that a tape measures best: x
 * and y before yaw, yaw before the clock, roll and pitch last. */
Choice observable(const Information& info, const Choice& wanted);

/** Throws std::runtime_error that says what the log is short of when there are too few frames, or
 * the robot hardly moves while they are taken. */
void require_motion(const ScanSet& scans, const PoseTrack& track);

/** The same when too little of the ground is seen by several frames. */
void require_ground(const Association& a);

}  // namespace talus::calibrate
