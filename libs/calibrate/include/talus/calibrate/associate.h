#pragma once
#include <talus/calibrate/contact.h>
#include <talus/calibrate/noise_model.h>
#include <talus/calibrate/residual.h>

namespace talus::calibrate
{
/** Which pieces of ground are looked for, and how many points are used. */
struct AssociationOptions
{
  double cell_m = 0.8;
  /** Patches are halved as long as four planes fit significantly better than one. */
  double least_cell_m = 0.8;
  double max_range_m = 20;
  double gate = 6;  //!< deviations from the plane up to which a point belongs to it
  double inlier_share = 0.7;  //!< of a cell's points that must: else something stands there
  std::size_t most_samples = 150000;
  int most_per_patch = 80;
};

/** sin(theta/2) of eq. 3 for each frame: theta is between the sensor's z axes of this and the frame
 * before. */
std::vector<double> half_turns(const ScanSet& scans, const PoseTrack& track, const Vector& v);

/** The patches of ground that the frames not held out see together, with the points on them. The
 * same input gives the same patches. */
Association associate(
    const ScanSet& scans, const PoseTrack& track, const std::vector<DrivenPlace>& driven,
    const Vector& v, const NoiseModel& noise, const AssociationOptions& options);

}  // namespace talus::calibrate
