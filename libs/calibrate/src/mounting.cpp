#include <talus/calibrate/mounting.h>

#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr double kDegree = 3.14159265358979323846 / 180;

/** Rotation about a coordinate axis, and its derivative by the angle. */
struct Turn
{
  Eigen::Matrix3d R, dR;
};
Turn turn(int axis, double angle_rad)
{
  const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(angle_rad, unit).toRotationMatrix();
  Eigen::Matrix3d cross;
  cross << 0, -unit.z(), unit.y(), unit.z(), 0, -unit.x(), -unit.y(), unit.x(), 0;
  return {R, cross * R};
}
}  // namespace

const std::array<ParameterInfo, kParameters>& parameter_infos()
{
  static const std::array<ParameterInfo, kParameters> infos{{
      {"x", "m", 1, 0.02},
      {"y", "m", 1, 0.02},
      {"z", "m", 1, 0.02},
      {"yaw", "deg", kDegree, 0.5 * kDegree},
      {"pitch", "deg", kDegree, 0.3 * kDegree},
      {"roll", "deg", kDegree, 0.3 * kDegree},
      {"time_offset", "s", 1, 0.02},
  }};
  return infos;
}

Vector vector_of(const mrpt::poses::CPose3D& T, double time_offset_s)
{
  Vector v;
  v << T.x(), T.y(), T.z(), T.yaw(), T.pitch(), T.roll(), time_offset_s;
  return v;
}

mrpt::poses::CPose3D pose_of(const Vector& v)
{
  return mrpt::poses::CPose3D(v[kX], v[kY], v[kZ], v[kYaw], v[kPitch], v[kRoll]);
}

MountingPose mounting_pose(const Vector& v)
{
  const Turn yaw = turn(2, v[kYaw]), pitch = turn(1, v[kPitch]), roll = turn(0, v[kRoll]);
  MountingPose m;
  m.R = yaw.R * pitch.R * roll.R;
  m.dR = {yaw.dR * pitch.R * roll.R, yaw.R * pitch.dR * roll.R, yaw.R * pitch.R * roll.dR};
  m.t_m = v.segment<3>(kX);
  return m;
}

}  // namespace talus::calibrate
