#include <talus/calibrate/residual.h>

#include <cmath>

namespace talus::calibrate
{
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
  for (int i = 0; i < 3; ++i) J.col(kYaw + i) = pose.R * (m.dR[static_cast<std::size_t>(i)] * p_sensor);
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
  return r;
}

ContactResidual contact_residual(const Contact& c, const Plane& plane, const ContactScatter& s)
{
  ContactResidual r;
  r.by_plane << 1 / s.height_m, c.at_m.x() / s.height_m, c.at_m.y() / s.height_m,  //
      0, 1 / s.slope, 0,  //
      0, 0, 1 / s.slope;
  const Eigen::Vector3d wanted(c.height_m / s.height_m, c.slope.x() / s.slope, c.slope.y() / s.slope);
  r.value = r.by_plane * plane - wanted;
  return r;
}

}  // namespace talus::calibrate
