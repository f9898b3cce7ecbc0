#pragma once
#include <talus/frame.h>
#include <talus/parameters.h>

#include <vector>

namespace talus::hints
{
struct Vec3
{
  double x = 0, y = 0, z = 0;
};
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b)
{
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(const Vec3& v);

Vec3 moved(const Pose& T, const Vec3& p);
Vec3 turned(const Pose& T, const Vec3& v);
inline Vec3 origin_of(const Pose& T) { return {T.x(), T.y(), T.z()}; }

/** Replaces `points` by up to `most` of a frame's points in the frame of the robot's base [m],
 * picked evenly and by a hash of `salt`: none that is not finite, out of range or of a body box.
 * `times_s`: after the stamp of the frame. */
void sample_in_base(
    const Frame& frame, const Parameters& parameters, std::size_t most, std::uint64_t salt,
    std::vector<Vec3>& points, std::vector<float>* times_s = nullptr);

/** The same with all points that are no farther from the base than `reach_m` along x, y and z. */
void near_in_base(
    const Frame& frame, const Parameters& parameters, double reach_m, std::vector<Vec3>& points);

}  // namespace talus::hints
