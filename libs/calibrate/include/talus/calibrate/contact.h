#pragma once
#include <talus/calibrate/patch.h>
#include <talus/calibrate/pose_track.h>

namespace talus::calibrate
{
/** A place of the robot's way: the ground below its base. */
struct DrivenPlace
{
  Eigen::Vector3d ground_m;  //!< map frame
  Eigen::Vector2d slope;  //!< dz/dx, dz/dy of the base's xy-plane
  double time_s = 0;
};

/** The way in steps of a few centimetres; `base_height_m` is that of the base above the ground. */
std::vector<DrivenPlace> driven_places(const PoseTrack& track, double base_height_m);

/** The mean of the places inside a square, or nothing. */
std::optional<Contact> contact_in(
    const std::vector<DrivenPlace>& places, const Eigen::Vector2d& center_m, double size_m);

/** How contact scatters about what it says on average; what it says on average is what is to be
 * calibrated. */
ContactScatter scatter_of(const std::vector<Patch>& patches);

}  // namespace talus::calibrate
