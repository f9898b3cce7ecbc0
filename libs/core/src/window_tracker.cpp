#include "window_tracker.h"
#include <talus/number_text.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace talus
{
namespace
{
constexpr double kMaxCellIndex = 1e9;
constexpr double kMaxHeight_m = 1e5;  //!< floats lie 8 mm apart there
constexpr double kNotRigid = 0.01;

kernels::WindowPose window_pose(const Pose& T_map_sensor, double min_x_m, double min_y_m)
{
  kernels::WindowPose w;
  for (int i = 0; i < 12; i++) w.m[i] = static_cast<float>(T_map_sensor.m[i]);
  w.m[3] = static_cast<float>(T_map_sensor.x() - min_x_m);
  w.m[7] = static_cast<float>(T_map_sensor.y() - min_y_m);
  return w;
}

Eigen::Isometry3d to_eigen(const Pose& p)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.matrix().topRows<3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(p.m.data());
  return T;
}

Pose interpolate(const TimedPose& a, const TimedPose& b, double time_s)
{
  const double w = b.time_s > a.time_s ? (time_s - a.time_s) / (b.time_s - a.time_s) : 0.0;
  const Eigen::Isometry3d A = to_eigen(a.T_map_sensor), B = to_eigen(b.T_map_sensor);
  const Eigen::Quaterniond qa(A.linear()), qb(B.linear());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = qa.slerp(w, qb).toRotationMatrix();
  T.translation() = A.translation() + w * (B.translation() - A.translation());
  Pose p;
  Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(p.m.data()) = T.matrix().topRows<3>();
  return p;
}

/** The path of the sensor at equal steps of time. */
void resample_path(const Frame& frame, double min_x_m, double min_y_m, kernels::FrameContext& f)
{
  const auto& path = frame.path;
  const double start = path.front().time_s, span = path.back().time_s - start;
  f.n_poses = kernels::kMaxPathPoses;
  f.path_start_s = static_cast<float>(start);
  f.path_rate_hz = static_cast<float>((f.n_poses - 1) / span);
  std::size_t segment = 0;
  for (int i = 0; i < f.n_poses; i++)
  {
    const double t = start + span * i / (f.n_poses - 1);
    while (segment + 2 < path.size() && path[segment + 1].time_s < t) segment++;
    f.poses[i] = window_pose(interpolate(path[segment], path[segment + 1], t), min_x_m, min_y_m);
  }
}

bool is_rotation(const Eigen::Matrix3d& R)
{
  return (R * R.transpose()).isApprox(Eigen::Matrix3d::Identity(), kNotRigid) &&
         R.determinant() > 0;
}

void check_pose(const Pose& p, double resolution_m)
{
  for (double v : p.m)
    if (!std::isfinite(v)) throw std::invalid_argument("the pose of the sensor is not finite");
  if (!is_rotation(to_eigen(p).linear()))
    throw std::invalid_argument(
        "the pose of the sensor is no rigid transform: the left 3x3 of its matrix must be a "
        "rotation");
  if (std::max(std::abs(p.x()), std::abs(p.y())) / resolution_m > kMaxCellIndex)
    throw std::invalid_argument(
        "the sensor is more than 1e9 cells away from the origin of the map: use a local origin");
  if (std::abs(p.z()) > kMaxHeight_m)
    throw std::invalid_argument(
        "the sensor is more than 100 km above or below the origin of the map: use a local origin");
}

/** NaN does not ascend either. */
void check_path(const std::vector<TimedPose>& path, double resolution_m)
{
  for (std::size_t i = 0; i < path.size(); i++)
  {
    check_pose(path[i].T_map_sensor, resolution_m);
    if (!std::isfinite(path[i].time_s) || (i > 0 && path[i].time_s < path[i - 1].time_s))
      throw std::invalid_argument(
          "the path of the frame must ascend in time: its pose " + std::to_string(i) + " is at " +
          fixed_text(path[i].time_s, 6) + " s" +
          (i ? ", the one before at " + fixed_text(path[i - 1].time_s, 6) + " s" : ""));
  }
}

/** (lambda_t sin(theta/2))^2, eq. 2 to 4, theta between the sensor's z axes in two consecutive
 * frames. */
double pose_change_factor(
    const std::array<double, 3>& z1, const std::array<double, 3>& z2, double lambda_t)
{
  const double cosine = z1[0] * z2[0] + z1[1] * z2[1] + z1[2] * z2[2];
  const double sine_of_half2 = std::max(0.0, (1 - std::min(cosine, 1.0)) / 2);
  return lambda_t * lambda_t * sine_of_half2;
}

}  // namespace

kernels::FrameContext WindowTracker::advance(const Frame& frame, const Parameters& p)
{
  check_pose(frame.T_map_sensor, p.resolution_m);
  check_path(frame.path, p.resolution_m);
  const int n = p.cells();
  const auto first_cell = [&](double v)
  { return static_cast<std::int64_t>(std::floor(v / p.resolution_m)) - n / 2; };
  const std::int64_t x = first_cell(frame.T_map_sensor.x()), y = first_cell(frame.T_map_sensor.y());
  const auto& m = frame.T_map_sensor.m;
  const std::array<double, 3> z_axis{m[2], m[6], m[10]};

  kernels::FrameContext f{};
  const auto moved = [&](std::int64_t now, std::int64_t before)
  { return started ? static_cast<int>(std::clamp<std::int64_t>(now - before, -n, n)) : n; };
  f.moved_x = moved(x, min_cell_x);
  f.moved_y = moved(y, min_cell_y);
  f.storage_x = storage(x, n);
  f.storage_y = storage(y, n);
  f.odd_x = static_cast<int>(x & 1);
  f.odd_y = static_cast<int>(y & 1);
  f.n_points = static_cast<int>(frame.size);
  f.pose_change2 =
      started ? static_cast<float>(pose_change_factor(last_z_axis, z_axis, p.lambda_t)) : 0.0f;

  const double min_x_m = static_cast<double>(x) * p.resolution_m;
  const double min_y_m = static_cast<double>(y) * p.resolution_m;
  f.n_poses = 1;
  f.poses[0] = window_pose(frame.T_map_sensor, min_x_m, min_y_m);
  f.sensor_x_m = f.poses[0].m[3];
  f.sensor_y_m = f.poses[0].m[7];
  f.sensor_z_m = f.poses[0].m[11];
  const bool moves = frame.path.size() >= 2 && frame.path.back().time_s > frame.path.front().time_s;
  f.has_times = frame.time_s && moves;
  if (f.has_times) resample_path(frame, min_x_m, min_y_m, f);

  started = true;
  min_cell_x = x;
  min_cell_y = y;
  last_z_axis = z_axis;
  return f;
}

}  // namespace talus
