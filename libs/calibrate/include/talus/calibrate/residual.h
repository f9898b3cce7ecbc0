#pragma once
#include <talus/calibrate/mounting.h>
#include <talus/calibrate/patch.h>
#include <talus/calibrate/pose_track.h>
#include <talus/calibrate/scan_set.h>

namespace talus::calibrate
{
/** Everything that all points of an evaluation share: the mounting, and the pose of each view. */
struct Geometry
{
  MountingPose mounting;
  std::vector<TrackPose> views;
};
/** Fills `out`, whose memory is used again. */
void evaluate_geometry(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, Geometry& out);

/** Signed distance [m] of a point from a plane, and its derivatives. */
struct Residual
{
  double distance_m = 0;
  Vector by_parameters;
  Eigen::Vector3d by_plane;
  Eigen::Vector3d at_sensor_m;  //!< where the derivatives are taken
};
Residual point_to_plane(
    const Geometry& g, std::uint32_t view, const Eigen::Vector3d& p_sensor,
    const Eigen::Vector2d& center_m, const Plane& plane);

/** The same for a sensor that errs along its beam: what its range lacks to the plane, times
 * `cosine` (of the angle between beam and normal, held fixed) so that it is as large as the
 * distance. A far point that errs by 5 cm lies 5 cm farther, not higher; the distance above the
 * place where it seems to be would tilt the plane towards the sensor. */
Residual beam_to_plane(
    const Geometry& g, std::uint32_t view, const Eigen::Vector3d& p_sensor,
    const Eigen::Vector2d& center_m, const Plane& plane, double cosine);

/** One of both, as the association was made. */
Residual residual_of(
    const Geometry& g, const Association& a, const Sample& s, const Patch& patch,
    const Eigen::Vector3d& p_sensor, const Plane& plane);

/** How a point in the map moves with the parameters [m, m/rad, m/s], one column each. */
Eigen::Matrix<double, 3, kParameters> point_by_parameters(
    const MountingPose& m, const TrackPose& pose, const Eigen::Vector3d& p_sensor);

/** The three residuals of a contact, each by its scatter: height, slopes in x and y. `by_plane` is
 * constant. */
struct ContactResidual
{
  Eigen::Vector3d value;
  Eigen::Matrix3d by_plane;
};
ContactResidual contact_residual(const Contact& c, const Plane& plane, const ContactScatter& s);

}  // namespace talus::calibrate
