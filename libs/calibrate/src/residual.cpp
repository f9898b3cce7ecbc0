#include <talus/calibrate/residual.h>

#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr double kMinOfCosine = 0.3;
}

void evaluate_geometry(const ScanSet& scans, const PoseTrack& track, const Vector& v, Geometry& out)
{
  out.mounting = mounting_pose(v);
  out.views.resize(scans.views().size());
  for (std::size_t i = 0; i < out.views.size(); ++i)
    out.views[i] = track.at(scans.views()[i].time_s + v[kTimeOffset]);
}

Eigen::Matrix<double, 3, kParameters> point_by_parameters(
    const MountingPose& m, const TrackPose& pose, const Eigen::Vector3d& p_sensor)
{
  Eigen::Matrix<double, 3, kParameters> J;
  J.middleCols<3>(kX) = pose.R;
  for (int i = 0; i < 3; ++i)
    J.col(kYaw + i) = pose.R * (m.dR[static_cast<std::size_t>(i)] * p_sensor);
  J.col(kTimeOffset) = pose.dR * (m.R * p_sensor + m.t_m) + pose.dt_mps;
  return J;
}

Residual point_to_plane(
    const Geometry& g, std::uint32_t view, const Eigen::Vector3d& p_sensor,
    const Eigen::Vector2d& center_m, const Plane& plane)
{
  const TrackPose& pose = g.views[view];
  const Eigen::Vector3d p_base = g.mounting.R * p_sensor + g.mounting.t_m;
  const Eigen::Vector3d p_map = pose.R * p_base + pose.t_m;
  const double u = p_map.x() - center_m.x(), v = p_map.y() - center_m.y();
  const double scale = 1 / std::sqrt(1 + plane[1] * plane[1] + plane[2] * plane[2]);
  const Eigen::Vector3d normal = Eigen::Vector3d(-plane[1], -plane[2], 1) * scale;

  Residual r;
  r.distance_m = (p_map.z() - plane[0] - plane[1] * u - plane[2] * v) * scale;
  const Eigen::Vector3d normal_base = pose.R.transpose() * normal;
  r.by_parameters.segment<3>(kX) = normal_base;
  for (int i = 0; i < 3; ++i)
    r.by_parameters[kYaw + i] =
        normal_base.dot(g.mounting.dR[static_cast<std::size_t>(i)] * p_sensor);
  r.by_parameters[kTimeOffset] = normal.dot(pose.dR * p_base + pose.dt_mps);
  const double shrink = r.distance_m * scale * scale;  // the normal's length grows with the slope
  r.by_plane << -scale, -u * scale - plane[1] * shrink, -v * scale - plane[2] * shrink;
  r.at_sensor_m = p_sensor;
  return r;
}

Residual beam_to_plane(
    const Geometry& g, std::uint32_t view, const Eigen::Vector3d& p_sensor,
    const Eigen::Vector2d& center_m, const Plane& plane, double cosine)
{
  const Residual far = point_to_plane(g, view, p_sensor, center_m, plane);
  const double range_m = p_sensor.norm();
  const Eigen::Vector3d beam = g.views[view].R * (g.mounting.R * p_sensor) / range_m;
  const double along = Eigen::Vector3d(-plane[1], -plane[2], 1).normalized().dot(beam);
  if (std::abs(along) < kMinOfCosine * cosine) return far;  // nearly misses the plane
  // Where the beam meets the plane the derivatives of range and distance agree but for a factor.
  const double missing_m = far.distance_m / along;
  Residual r = point_to_plane(g, view, p_sensor * (1 - missing_m / range_m), center_m, plane);
  const double factor = cosine / std::abs(along);
  r.distance_m = far.distance_m * factor;
  r.by_parameters *= factor;
  r.by_plane *= factor;
  return r;
}

Residual residual_of(
    const Geometry& g, const Association& a, const Sample& s, const Patch& patch,
    const Eigen::Vector3d& p_sensor, const Plane& plane)
{
  return a.along_beam ? beam_to_plane(g, s.view, p_sensor, patch.center_m, plane, s.cosine)
                      : point_to_plane(g, s.view, p_sensor, patch.center_m, plane);
}

ContactResidual contact_residual(const Contact& c, const Plane& plane, const ContactScatter& s)
{
  ContactResidual r;
  r.by_plane << 1 / s.height_m, c.at_m.x() / s.height_m, c.at_m.y() / s.height_m,  //
      0, 1 / s.slope, 0,  //
      0, 0, 1 / s.slope;
  const Eigen::Vector3d wanted(
      c.height_m / s.height_m, c.slope.x() / s.slope, c.slope.y() / s.slope);
  r.value = r.by_plane * plane - wanted;
  return r;
}

}  // namespace talus::calibrate
