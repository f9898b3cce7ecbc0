#pragma once
#include <mrpt/poses/CPose3D.h>

#include <Eigen/Dense>

#include <array>

namespace talus::calibrate
{
/** What is estimated of the sensor's mounting and clock. The mounting is T_base_sensor with
 * R = Rz(yaw) Ry(pitch) Rx(roll), as MRPT's CPose3D: positive pitch looks down. */
enum Parameter : int
{
  kX,
  kY,
  kZ,
  kYaw,
  kPitch,
  kRoll,
  /** Added to a stamp of the log it gives the time of the trajectory. */
  kTimeOffset,
  kParameters
};

/** Metres, radians and seconds, indexed by Parameter. */
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;
/** Which parameters are estimated. */
using Choice = std::array<bool, kParameters>;

/** How a parameter is shown, and when an estimate of it is worth having. */
struct ParameterInfo
{
  const char* name;
  const char* unit;  //!< shown to people
  double per_unit;  //!< internal value = shown value * per_unit
  double useful_sigma;  //!< known no better than this [m, rad, s] it counts as not observable
};
const std::array<ParameterInfo, kParameters>& parameter_infos();

Vector vector_of(const mrpt::poses::CPose3D& T_base_sensor, double time_offset_s = 0);
mrpt::poses::CPose3D pose_of(const Vector& v);

/** T_base_sensor and how its rotation changes with yaw, pitch and roll. */
struct MountingPose
{
  Eigen::Matrix3d R;
  std::array<Eigen::Matrix3d, 3> dR;  //!< by yaw, pitch, roll [1/rad]
  Eigen::Vector3d t_m;
};
MountingPose mounting_pose(const Vector& v);

}  // namespace talus::calibrate
