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
  /** False: the log says nothing about it (lambda_t of a robot that never tilts). */
  std::array<bool, kNoiseParameters> constrained{};
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
 * variance, or an outlier that may lie anywhere within `gate_m`. A patch's plane follows its points;
 * distances are enlarged by what it takes away (leverage). `previous` gave the planes' weights. */
NoiseFit fit_noise(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Association& a,
    NoiseKind kind);

}  // namespace talus::calibrate
