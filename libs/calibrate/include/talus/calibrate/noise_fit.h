#pragma once
#include <talus/calibrate/information.h>

#include <array>

namespace talus::calibrate
{
enum NoiseParameter : int
{
  kCBeam,
  kABeam,
  kLambdaT,
  kGround,
  kNoiseParameters
};

/** The noise by maximum likelihood. */
struct NoiseFit
{
  NoiseModel model;
  std::array<double, kNoiseParameters> sigma{};  //!< of c_beam, a_beam, lambda_t, ground
  /** False: not significantly different from 0, and set to 0. */
  std::array<bool, kNoiseParameters> constrained{};
  bool turns =
      false;  //!< the sensor tilts between frames, without which lambda_t is not observable
  double outlier_share = 0;
  double log_likelihood = 0;  //!< a point
  std::size_t points = 0;
};

/** How the noise is taken to act. */
enum class NoiseKind
{
  Auto,  //!< as the likelihood says
  Beam,
  Height
};

/** Fits eq. 2-4 to the distances of the points from their patches: each is normal with the model's
 * variance, or an outlier that may lie anywhere near. Distances are taken from curved surfaces
 * through the patches, and enlarged by what a surface that follows its points takes away
 * (leverage).
 */
NoiseFit fit_noise(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Association& a,
    NoiseKind kind);

}  // namespace talus::calibrate
