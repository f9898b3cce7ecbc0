#pragma once
#include <talus/calibrate/held_out.h>
#include <talus/calibrate/noise_fit.h>

#include <functional>
#include <string>
#include <vector>

namespace talus::calibrate
{
struct Options
{
  Vector given = Vector::Zero();  //!< mounting and time offset as they are believed to be
  /** Use that the robot stands on the ground: its base is ScanSet::base_height_m() above it and
   * parallel to it, on average over the path. */
  bool use_contact = true;
  double max_time_offset_s = 0.3;  //!< larger estimates are refused
  NoiseKind noise_kind = NoiseKind::Auto;
  std::size_t most_samples = 100000;
  /** Gets the share of the work done, 0..1, and what goes on. */
  std::function<void(double, const std::string&)> progress = [](double, const std::string&) {};
};

struct Result
{
  Vector given, estimate;
  Vector sigma = Vector::Zero();  //!< 1-sigma, 0 for what was kept
  Matrix covariance = Matrix::Zero();
  Choice observable{};  //!< the others were kept as given
  NoiseFit noise;
  BeforeAfter held_out;
  ContactScatter contact;
  std::size_t patches = 0, samples = 0;
  int rounds = 0;  //!< of association and solution
  /** The held-out frames fit the given mounting better, or show no ground: not to be used. */
  bool gains_nothing = false;
  /** They hardly fit it better, or their 95 % worse, than the given mounting: not to be
   * recommended. */
  bool is_doubtful = false;
  std::vector<std::string> warnings;
};

/** Estimates mounting, time offset and noise (doc/calibration.md has the method). Throws
 * std::runtime_error that says what the log lacks. */
Result calibrate(const ScanSet& scans, const PoseTrack& track, const Options& options);

}  // namespace talus::calibrate
