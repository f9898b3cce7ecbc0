#pragma once
#include <talus/calibrate/information.h>

namespace talus::calibrate
{
/** Changes the chosen parameters and all planes of `a` until the robust sum of squares of all
 * residuals, points on planes and contacts, is least (Ceres, Levenberg-Marquardt; the planes are
 * eliminated by a Schur complement). Throws std::runtime_error when Ceres fails. */
Vector solve(
    const ScanSet& scans, const PoseTrack& track, const Vector& start, const Choice& chosen,
    Association& a);

}  // namespace talus::calibrate
