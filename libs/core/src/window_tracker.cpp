#include "window_tracker.h"
#include "kernels/rays.h"
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
constexpr double kNotRigid = 0.01;
constexpr double kFarthestSensor_m = 1000;  //!< from the base
constexpr double kMinSensorHeight_m = 0.1;  //!< a lower sensor has its base above the ground
constexpr double kMinUpright = 1e-6;  //!< min z component of the z axis of an upright base
constexpr std::array<double, 3> kNotSeen{0, 0, 0};  //!< no axis

kernels::WindowPose window_pose(const Pose& T_map_sensor, double min_x_m, double min_y_m)
{
  kernels::WindowPose w;
  for (int i = 0; i < 12; i++) w.m[i] = static_cast<float>(T_map_sensor.m[i]);
  w.m[3] = static_cast<float>(T_map_sensor.x() - min_x_m);
  w.m[7] = static_cast<float>(T_map_sensor.y() - min_y_m);
  return w;
}

std::int64_t cell_of(double position_m, double resolution_m)
{
  return static_cast<std::int64_t>(std::floor(position_m / resolution_m));
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

/** Rings from a cell to the farthest one of a window of n x n, and one for all beyond. */
int rings_around(int x, int y, int n)
{
  const int farthest = std::max({x, n - 1 - x, y, n - 1 - y});
  return std::min(farthest + 2, kernels::most_rings(n));
}

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

/** Finds how the points of a frame come into a window. */
void locate_points(const Frame& frame, double min_x_m, double min_y_m, kernels::FrameContext& f)
{
  f.n_points = static_cast<int>(frame.size);
  f.n_poses = 1;
  const kernels::WindowPose sensor = window_pose(frame.T_map_sensor, min_x_m, min_y_m);
  f.poses[0] = sensor;
  f.sensor_x_m = sensor.m[3];
  f.sensor_y_m = sensor.m[7];
  f.sensor_z_map_m = f.sensor_z_m = sensor.m[11];
  const bool moves = frame.path.size() >= 2 && frame.path.back().time_s > frame.path.front().time_s;
  f.has_times = frame.time_s && moves;
  if (f.has_times) resample_path(frame, min_x_m, min_y_m, f);
}

void locate_base(
    const Frame& frame, const Pose& T_map_base, double min_x_m, double min_y_m,
    kernels::FrameContext& f)
{
  const Pose T_base_sensor = frame.T_base_sensor.value_or(Pose{});
  for (std::size_t i = 0; i < 12; i++) f.T_base_sensor[i] = static_cast<float>(T_base_sensor.m[i]);
  const kernels::WindowPose base = window_pose(T_map_base, min_x_m, min_y_m);
  f.has_base = frame.T_base_sensor && frame.T_base_sensor->z() >= kMinSensorHeight_m;
  f.base_x_m = base.m[3];
  f.base_y_m = base.m[7];
  f.base_z_m = base.m[11];
  const auto& m = T_map_base.m;
  const auto slope = [&](double normal)
  { return static_cast<float>(std::clamp(-normal / std::max(m[10], kMinUpright), -1.0, 1.0)); };
  f.base_slope_x = slope(m[2]);
  f.base_slope_y = slope(m[6]);
}

/** The values of a frame in the window with this first cell, whatever came before. */
kernels::FrameContext context_in(
    const Frame& frame, const Pose& T_map_base, std::int64_t x, std::int64_t y, const Parameters& p)
{
  const double min_x_m = static_cast<double>(x) * p.resolution_m;
  const double min_y_m = static_cast<double>(y) * p.resolution_m;
  kernels::FrameContext f{};
  f.storage_x = WindowTracker::storage(x, p.cells());
  f.storage_y = WindowTracker::storage(y, p.cells());
  f.odd_x = static_cast<int>(x & 1);
  f.odd_y = static_cast<int>(y & 1);
  locate_points(frame, min_x_m, min_y_m, f);
  locate_base(frame, T_map_base, min_x_m, min_y_m, f);
  return f;
}

bool is_rotation(const Eigen::Matrix3d& R)
{
  return (R * R.transpose()).isApprox(Eigen::Matrix3d::Identity(), kNotRigid) &&
         R.determinant() > 0;
}

void check_transform(const Pose& p, const char* what)
{
  for (double v : p.m)
    if (!std::isfinite(v)) throw std::invalid_argument(std::string(what) + " is not finite");
  if (!is_rotation(to_eigen(p).linear()))
    throw std::invalid_argument(
        std::string(what) +
        " is no rigid transform: the left 3x3 of its matrix must be a rotation");
}

void check_position(const Pose& p, const char* who, double resolution_m)
{
  if (std::max(std::abs(p.x()), std::abs(p.y())) / resolution_m > kMaxCellIndex)
    throw std::invalid_argument(
        std::string(who) +
        " is more than 1e9 cells away from the origin of the map: use a local origin");
  if (std::abs(p.z()) > kMaxHeight_m)
    throw std::invalid_argument(
        std::string(who) +
        " is more than 100 km above or below the origin of the map: use a local origin");
}

void check_pose(const Pose& p, double resolution_m)
{
  check_transform(p, "the pose of the sensor");
  check_position(p, "the sensor", resolution_m);
}

void check_mounting(const Pose& T_base_sensor)
{
  check_transform(T_base_sensor, "the pose of the sensor on the robot, T_base_sensor,");
  if (std::hypot(T_base_sensor.x(), T_base_sensor.y(), T_base_sensor.z()) > kFarthestSensor_m)
    throw std::invalid_argument(
        "the sensor is more than 1 km away from the robot's base: T_base_sensor is in metres");
}

/** NaN counts as not ascending. */
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

/** (lambda_t sin(theta/2))^2, eq. 2 to 4, theta between the z axes in two consecutive frames. */
double pose_change_factor(
    const std::array<double, 3>& z1, const std::array<double, 3>& z2, double lambda_t)
{
  const double cosine = z1[0] * z2[0] + z1[1] * z2[1] + z1[2] * z2[2];
  const double sine_of_half2 = std::max(0.0, (1 - std::min(cosine, 1.0)) / 2);
  return lambda_t * lambda_t * sine_of_half2;
}

}  // namespace

/** Written without Eigen, whose rounding depends on the vector instructions of the processor. */
Pose pose_of_base(const Pose& T_map_sensor, const std::optional<Pose>& T_base_sensor)
{
  if (!T_base_sensor) return T_map_sensor;
  const auto &a = T_map_sensor.m, &b = T_base_sensor->m;
  Pose T_map_base;
  for (std::size_t row = 0; row < 12; row += 4)
  {
    double* const to = &T_map_base.m[row];
    for (std::size_t i = 0; i < 3; i++)
      to[i] = a[row] * b[4 * i] + a[row + 1] * b[4 * i + 1] + a[row + 2] * b[4 * i + 2];
    to[3] = a[row + 3] - (to[0] * b[3] + to[1] * b[7] + to[2] * b[11]);
  }
  return T_map_base;
}

std::array<double, 3>& WindowTracker::z_axis_of(std::uint32_t sensor)
{
  const auto found = std::find_if(
      sensors.begin(), sensors.end(), [&](const Sensor& s) { return s.number == sensor; });
  if (found != sensors.end()) return found->z_axis;
  if (sensors.size() == kMaxSensors)
    throw std::invalid_argument(
        "frames of more than " + std::to_string(kMaxSensors) +
        " sensors: Frame::sensor is a number for each sensor, and not for each frame");
  return sensors.emplace_back(Sensor{sensor, kNotSeen}).z_axis;
}

Pose WindowTracker::checked_base(const Frame& frame, const Parameters& p)
{
  check_pose(frame.T_map_sensor, p.resolution_m);
  check_path(frame.path, p.resolution_m);
  if (frame.T_base_sensor) check_mounting(*frame.T_base_sensor);
  const Pose T_map_base = pose_of_base(frame.T_map_sensor, frame.T_base_sensor);
  check_position(T_map_base, "the robot's base", p.resolution_m);
  return T_map_base;
}

std::pair<std::int64_t, std::int64_t> WindowTracker::min_cell(
    const Pose& T_map_base, const Parameters& p)
{
  const int half = p.cells() / 2;
  return {
      cell_of(T_map_base.x(), p.resolution_m) - half,
      cell_of(T_map_base.y(), p.resolution_m) - half};
}

kernels::FrameContext WindowTracker::advance(const Frame& frame, const Parameters& p)
{
  const Pose T_map_base = checked_base(frame, p);
  const int n = p.cells();
  const auto [x, y] = min_cell(T_map_base, p);
  const auto& m = frame.T_map_sensor.m;
  const std::array<double, 3> z_axis{m[2], m[6], m[10]};
  std::array<double, 3>& last_z_axis = z_axis_of(frame.sensor);

  kernels::FrameContext f = context_in(frame, T_map_base, x, y, p);
  const auto moved = [&](std::int64_t now, std::int64_t before)
  { return started ? static_cast<int>(std::clamp<std::int64_t>(now - before, -n, n)) : n; };
  f.starts_map = !started;
  f.moved_x = moved(x, min_cell_x);
  f.moved_y = moved(y, min_cell_y);
  f.pose_change2 = last_z_axis == kNotSeen
                       ? 0.0f
                       : static_cast<float>(pose_change_factor(last_z_axis, z_axis, p.lambda_t));
  f.rings = rings_around(
      static_cast<int>(cell_of(frame.T_map_sensor.x(), p.resolution_m) - x),
      static_cast<int>(cell_of(frame.T_map_sensor.y(), p.resolution_m) - y), n);
  started = true;
  min_cell_x = x;
  min_cell_y = y;
  last_z_axis = z_axis;
  return f;
}

kernels::FrameContext WindowTracker::look_up(const Frame& frame, const Parameters& p) const
{
  return context_in(frame, checked_base(frame, p), min_cell_x, min_cell_y, p);
}

}  // namespace talus
