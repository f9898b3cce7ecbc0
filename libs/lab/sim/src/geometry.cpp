#include <talus/sim/geometry.h>

namespace talus::sim
{
Pose pose_from_axes(const Vec3& x_axis, const Vec3& y_axis, const Vec3& z_axis, const Vec3& t_m)
{
  Pose T;
  T.m = {x_axis.x, y_axis.x, z_axis.x, t_m.x,    x_axis.y, y_axis.y,
         z_axis.y, t_m.y,    x_axis.z, y_axis.z, z_axis.z, t_m.z};
  return T;
}

Pose pose_from_rpy(const Vec3& t_m, double roll_rad, double pitch_rad, double yaw_rad)
{
  const double cr = std::cos(roll_rad), sr = std::sin(roll_rad);
  const double cp = std::cos(pitch_rad), sp = std::sin(pitch_rad);
  const double cy = std::cos(yaw_rad), sy = std::sin(yaw_rad);
  return pose_from_axes(
      {cy * cp, sy * cp, -sp}, {cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr},
      {cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr}, t_m);
}

Pose compose(const Pose& T_a_b, const Pose& T_b_c)
{
  const auto axis = [&](int i) {
    return rotate(T_a_b, {T_b_c.m[i], T_b_c.m[4 + i], T_b_c.m[8 + i]});
  };
  return pose_from_axes(
      axis(0), axis(1), axis(2), transform(T_a_b, {T_b_c.x(), T_b_c.y(), T_b_c.z()}));
}

Pose inverse(const Pose& T_a_b)
{
  const auto& m = T_a_b.m;
  const Vec3 t = rotate_back(T_a_b, {T_a_b.x(), T_a_b.y(), T_a_b.z()});
  return pose_from_axes({m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, t * -1.0);
}

}  // namespace talus::sim
