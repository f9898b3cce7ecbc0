#pragma once
#include <talus/calibrate/noise_model.h>
#include <talus/calibrate/patch.h>
#include <talus/calibrate/pose_track.h>
#include <talus/calibrate/residual.h>

namespace talus::calibrate
{
/** A position on the robot's path: the ground below its base. */
struct DrivenPlace
{
  Eigen::Vector3d ground_m;  //!< map frame
  Eigen::Vector2d slope;  //!< dz/dx, dz/dy of the base's xy-plane
  double time_s = 0;
};

/** The path in steps of a few centimetres; `base_height_m` is that of the base above the ground. */
std::vector<DrivenPlace> driven_places(const PoseTrack& track, double base_height_m);

/** The mean of the places inside a square, or nothing. */
std::optional<Contact> contact_in(
    const std::vector<DrivenPlace>& places, const Eigen::Vector2d& center_m, double size_m);

/** How contact scatters about what it says on average; what it says on average is what is to be
 * calibrated. */
ContactScatter scatter_of(const std::vector<Patch>& patches);

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
