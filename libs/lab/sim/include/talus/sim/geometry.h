#pragma once
#include <talus/frame.h>

#include <cmath>

namespace talus::sim
{
constexpr double kPi = 3.14159265358979323846;
constexpr double radians(double deg) { return deg * (kPi / 180.0); }

/** A point [m] or a direction, in the frame its name says. */
struct Vec3
{
  double x = 0, y = 0, z = 0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(const Vec3& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b)
{
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalized(const Vec3& a) { return a * (1.0 / norm(a)); }

/** Half line; with a unit direction the parameter of a point on it is its range [m]. */
struct Ray
{
  Vec3 origin_m;
  Vec3 direction;

  Vec3 at(double range_m) const { return origin_m + direction * range_m; }
};

/** Pose whose axes are the given unit vectors and whose origin is `t_m`. */
Pose pose_from_axes(const Vec3& x_axis, const Vec3& y_axis, const Vec3& z_axis, const Vec3& t_m);

/** R = Rz(yaw) Ry(pitch) Rx(roll), as MRPT's CPose3D: positive pitch looks down. */
Pose pose_from_rpy(const Vec3& t_m, double roll_rad, double pitch_rad = 0.0, double yaw_rad = 0.0);

/** T_a_c = T_a_b * T_b_c. */
Pose compose(const Pose& T_a_b, const Pose& T_b_c);

/** T_b_a of T_a_b. */
Pose inverse(const Pose& T_a_b);

/** R * v, without the translation. */
inline Vec3 rotate(const Pose& T, const Vec3& v)
{
  return {
      T.m[0] * v.x + T.m[1] * v.y + T.m[2] * v.z, T.m[4] * v.x + T.m[5] * v.y + T.m[6] * v.z,
      T.m[8] * v.x + T.m[9] * v.y + T.m[10] * v.z};
}

/** transpose(R) * v. */
inline Vec3 rotate_back(const Pose& T, const Vec3& v)
{
  return {
      T.m[0] * v.x + T.m[4] * v.y + T.m[8] * v.z, T.m[1] * v.x + T.m[5] * v.y + T.m[9] * v.z,
      T.m[2] * v.x + T.m[6] * v.y + T.m[10] * v.z};
}

inline Vec3 transform(const Pose& T, const Vec3& p)
{
  return rotate(T, p) + Vec3{T.x(), T.y(), T.z()};
}

}  // namespace talus::sim
