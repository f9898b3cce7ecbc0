#include <talus/calibrate/first_guess.h>

#include <talus/io/quantile.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace talus::calibrate
{
namespace
{
constexpr double kNear_m = 6, kFewPoints = 40;
constexpr int kMostFrames = 60;

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
  if (static_cast<double>(points.size()) < kFewPoints) return std::nullopt;
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
}  // namespace

Vector level_mounting(const ScanSet& scans, const Vector& given)
{
  std::array<std::vector<double>, 3> values;
  const MountingPose m = mounting_pose(given);
  const int every = std::max(1, scans.frames() / kMostFrames);
  const auto& views = scans.views();
  for (std::size_t i = 0, end = 0; i < views.size(); i = end)
  {
    while (end < views.size() && views[end].frame == views[i].frame) ++end;
    if (views[i].frame % every != 0) continue;
    const std::uint32_t last = views[end - 1].first + views[end - 1].count;
    if (const auto plane = ground_plane(scans, views[i].first, last, m))
      for (int k = 0; k < 3; ++k) values[static_cast<std::size_t>(k)].push_back((*plane)[k]);
  }
  if (values[0].empty()) return given;
  const double a = io::quantile(values[0], 0.5), b = io::quantile(values[1], 0.5),
               c = io::quantile(values[2], 0.5);

  // The rotation that brings the seen normal upright, and the lift that is left then.
  const Eigen::Vector3d normal = Eigen::Vector3d(-b, -c, 1).normalized();
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond::FromTwoVectors(normal, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d R = turn * m.R;
  Vector v = given;
  v[kPitch] = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  v[kRoll] = std::atan2(R(2, 1), R(2, 2));
  const double seen_below = normal.dot(m.t_m - Eigen::Vector3d(0, 0, a));  // sensor above ground
  v[kZ] = seen_below - scans.base_height_m();
  return v;
}

}  // namespace talus::calibrate
