#include <talus/calibrate/held_out.h>

#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace talus::calibrate
{
namespace
{
constexpr double kNear_m = 6, kFewNearPoints = 40;
constexpr int kMaxFrames = 60;
constexpr double kHalfTurn = 3.14159265358979323846;

/** z = a + b x + c y in the base frame, the ground near the robot as one frame shows it. */
std::optional<Eigen::Vector3d> ground_plane(
    const ScanSet& scans, std::uint32_t first, std::uint32_t end, const MountingPose& m)
{
  std::vector<Eigen::Vector3d> points;
  for (std::uint32_t k = first; k < end; ++k)
  {
    const Eigen::Vector3d p = m.R * scans.point(k) + m.t_m;
    if (p.head<2>().norm() < kNear_m) points.push_back(p);
  }
  if (static_cast<double>(points.size()) < kFewNearPoints) return std::nullopt;
  Eigen::Vector3d plane(-scans.base_height_m(), 0, 0);
  for (const double scale_m : {0.4, 0.3, 0.2, 0.1, 0.05, 0.05, 0.05})
  {
    Eigen::Matrix3d N = 1e-6 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = 1e-6 * plane;
    for (const auto& p : points)
    {
      const Eigen::Vector3d q(1, p.x(), p.y());
      const double e = (p.z() - q.dot(plane)) / scale_m, weight = 1 / std::pow(1 + e * e, 2);
      N += weight * q * q.transpose();
      b += weight * q * p.z();
    }
    plane = N.ldlt().solve(b);
  }
  return plane;
}

/** The ground near the robot in the base frame, z = a + b x + c y, for the median frame. */
std::optional<Eigen::Vector3d> median_plane(const ScanSet& scans, const Vector& given)
{
  std::array<std::vector<double>, 3> values;
  const MountingPose m = mounting_pose(given);
  const int every = std::max(1, scans.frames() / kMaxFrames);
  const auto& views = scans.views();
  for (std::size_t i = 0, end = 0; i < views.size(); i = end)
  {
    while (end < views.size() && views[end].frame == views[i].frame) ++end;
    if (views[i].frame % every != 0) continue;
    const std::uint32_t last = views[end - 1].first + views[end - 1].count;
    if (const auto plane = ground_plane(scans, views[i].first, last, m))
      for (int k = 0; k < 3; ++k) values[static_cast<std::size_t>(k)].push_back((*plane)[k]);
  }
  if (values[0].empty()) return std::nullopt;
  return Eigen::Vector3d(
      io::quantile(values[0], 0.5), io::quantile(values[1], 0.5), io::quantile(values[2], 0.5));
}

Eigen::Vector3d normal_of(const Eigen::Vector3d& plane)
{
  return Eigen::Vector3d(-plane[1], -plane[2], 1).normalized();
}

double sensor_above_m(const Eigen::Vector3d& plane, const Vector& v)
{
  return normal_of(plane).dot(v.segment<3>(kX) - Eigen::Vector3d(0, 0, plane[0]));
}

/** How far the ground is from where the robot stands [m], if a mounting is right; infinite where
 * there is none below the sensor. */
double ground_off_m(const ScanSet& scans, const Vector& v)
{
  const auto plane = median_plane(scans, v);
  if (!plane || sensor_above_m(*plane, v) <= 0) return HUGE_VAL;
  return std::abs((*plane)[0] + scans.base_height_m());
}
}  // namespace

Vector rolled_over(Vector v)
{
  v[kRoll] = std::remainder(v[kRoll] + kHalfTurn, 2 * kHalfTurn);
  return v;
}

bool is_upside_down(const ScanSet& scans, const ScanSet& rolled_scans, const Vector& given)
{
  constexpr double kMayBeOff_m = 0.4;
  const double off_m = ground_off_m(scans, given);
  return off_m > kMayBeOff_m && 2 * ground_off_m(rolled_scans, rolled_over(given)) < off_m;
}

void require_level_ground(const ScanSet& scans, const Vector& v)
{
  constexpr double kMax_rad = 10 * kHalfTurn / 180;
  const auto plane = median_plane(scans, v);
  if (!plane) return;
  const double lean_rad = std::acos(std::clamp(normal_of(*plane).z(), -1.0, 1.0));
  if (lean_rad <= kMax_rad) return;
  throw std::runtime_error(
      "does not show how the sensor is tilted: as it is given, the ground under the robot leans "
      "by " +
      fixed_text(lean_rad * 180 / kHalfTurn, 0) +
      " degrees. Give the mounting to about 5 degrees (--mount), or a drive with turns; if the "
      "robot's base is not parallel to the ground, say --no-contact");
}

Vector level_mounting(const ScanSet& scans, const Vector& given)
{
  const auto plane = median_plane(scans, given);
  if (!plane) return given;
  const double seen_below = sensor_above_m(*plane, given);
  if (seen_below <= 0)
    throw std::runtime_error(
        "shows the ground above the sensor, by " + fixed_text(-seen_below, 2) +
        " m: is the sensor mounted upside down or on its side, other than was said? Give its "
        "mounting to about 5 degrees (--mount), and --base-height");
  // The rotation that brings the seen normal upright, and the lift that is left then.
  const Eigen::Vector3d normal = normal_of(*plane);
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond::FromTwoVectors(normal, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d R = turn * mounting_pose(given).R;
  Vector v = given;
  v[kPitch] = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  const double roll = std::atan2(R(2, 1), R(2, 2));
  v[kRoll] = given[kRoll] + std::remainder(roll - given[kRoll], 2 * kHalfTurn);  // no turn more
  v[kZ] = seen_below - scans.base_height_m();
  return v;
}

}  // namespace talus::calibrate
