#include "base_points.h"

#include <algorithm>
#include <cmath>

namespace talus::hints
{
namespace
{
/** splitmix64 */
std::uint64_t hash(std::uint64_t v)
{
  v += 0x9e3779b97f4a7c15U;
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9U;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebU;
  return v ^ (v >> 31);
}

bool is_in(const BodyBox& b, const Vec3& p)
{
  return p.x >= b.min_x_m && p.x <= b.max_x_m && p.y >= b.min_y_m && p.y <= b.max_y_m &&
         p.z >= b.min_z_m && p.z <= b.max_z_m;
}

bool is_of_body(const Parameters& parameters, const Vec3& p)
{
  const auto& boxes = parameters.body_boxes_m;
  return std::any_of(boxes.begin(), boxes.end(), [&](const BodyBox& b) { return is_in(b, p); });
}

/** What of a point counts: its range is one that the map takes. */
struct RangeGate
{
  explicit RangeGate(const Parameters& p)
      : least(p.min_range_m * p.min_range_m), most(p.max_range_m * p.max_range_m)
  {
  }
  bool takes(double squared_m2) const { return squared_m2 >= least && squared_m2 <= most; }
  double least, most;
};
}  // namespace

double length(const Vec3& v) { return std::sqrt(dot(v, v)); }

Vec3 turned(const Pose& T, const Vec3& v)
{
  const auto& m = T.m;
  return {
      m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
      m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

Vec3 moved(const Pose& T, const Vec3& p)
{
  const Vec3 v = turned(T, p);
  return {v.x + T.x(), v.y + T.y(), v.z + T.z()};
}

void sample_in_base(
    const Frame& frame, const Parameters& parameters, std::size_t most, std::uint64_t salt,
    std::vector<Vec3>& points, std::vector<float>* times_s)
{
  points.clear();
  if (times_s) times_s->clear();
  const bool has_times = frame.time_s && !frame.path.empty();
  const Pose T_base_sensor = frame.T_base_sensor.value_or(Pose{});
  const RangeGate gate(parameters);
  const std::size_t stride = std::max<std::size_t>(1, (frame.size + most - 1) / most);
  for (std::size_t from = 0; from < frame.size; from += stride)
  {
    // Not every n-th: scans come ring by ring, and n may be the number of rings.
    const std::size_t i = from + (stride > 1 ? hash(salt ^ from) % stride : 0);
    if (i >= frame.size) break;
    const Vec3 p{frame.x_m[i], frame.y_m[i], frame.z_m[i]};
    if (!gate.takes(dot(p, p))) continue;  // nor what is not finite
    const Vec3 p_base = moved(T_base_sensor, p);
    if (is_of_body(parameters, p_base)) continue;
    points.push_back(p_base);
    if (times_s) times_s->push_back(has_times ? frame.time_s[i] : 0);
  }
}

void near_in_base(
    const Frame& frame, const Parameters& parameters, double reach_m, std::vector<Vec3>& points)
{
  points.clear();
  const Pose T_base_sensor = frame.T_base_sensor.value_or(Pose{});
  const RangeGate gate(parameters);
  const double farthest_m = std::sqrt(3.0) * reach_m + length(origin_of(T_base_sensor));
  for (std::size_t i = 0; i < frame.size; ++i)
  {
    const Vec3 p{frame.x_m[i], frame.y_m[i], frame.z_m[i]};
    const double squared_m2 = dot(p, p);
    if (!(squared_m2 <= farthest_m * farthest_m) || !gate.takes(squared_m2)) continue;
    const Vec3 b = moved(T_base_sensor, p);
    const double far_m = std::max({std::abs(b.x), std::abs(b.y), std::abs(b.z)});
    if (far_m <= reach_m && !is_of_body(parameters, b)) points.push_back(b);
  }
}

}  // namespace talus::hints
