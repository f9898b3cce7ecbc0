#include "simulated_robot.h"

#include <talus/sim/truth.h>

#include <algorithm>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr double kRobotStep_s = 0.025, kLag_s = 0.15, kMaxAcceleration = 2.0;  // m/s^2
constexpr double kTruthCell_m = 0.05;

double approach(double value, double wanted, double most_change)
{
  const double change = (wanted - value) * kRobotStep_s / kLag_s;
  return value + std::clamp(change, -most_change, most_change);
}
}  // namespace

Footprint RobotBody::footprint() const
{
  Footprint f;
  f.max_x_m = length_m / 2;
  f.max_y_m = width_m / 2;
  f.min_x_m = -f.max_x_m;
  f.min_y_m = -f.max_y_m;
  f.ground_clearance_m = climbs_m;
  f.max_step_m = steps_m;
  const double ahead_m = f.max_x_m - f.wheel_radius_m, left_m = f.max_y_m - f.wheel_radius_m;
  f.wheels = {{ahead_m, left_m}, {ahead_m, -left_m}, {-ahead_m, left_m}, {-ahead_m, -left_m}};
  return f;
}

SimulatedRobot::SimulatedRobot(const sim::World& world, const Noise& noise, std::uint64_t seed)
    : world_(world),
      noise_(noise),
      scanner_(*sim::find_scanner(world.sensors[0].scanner)),
      seed_(seed)
{
  const auto& way = world.robot.waypoints;
  x_m_ = way[0].x;
  y_m_ = way[0].y;
  yaw_rad_ = way.size() > 1 ? std::atan2(way[1].y - y_m_, way[1].x - x_m_) : world.robot.yaw_rad;
  scanner_.noise_m = noise.range_m;
  scanner_.max_range_m = world.sensors[0].max_range_m.value_or(scanner_.max_range_m);
  scanner_.dropout = world.sensors[0].dropout.value_or(scanner_.dropout);
}

void SimulatedRobot::command(double v_mps, double w_radps)
{
  v_wanted_ = v_mps;
  w_wanted_ = w_radps;
}

void SimulatedRobot::drive(double seconds)
{
  const int steps = static_cast<int>(std::lround(seconds / kRobotStep_s));
  for (int i = 0; i < steps; i++)
  {
    v_mps_ = approach(v_mps_, v_wanted_, kMaxAcceleration * kRobotStep_s);
    w_radps_ = approach(w_radps_, w_wanted_, 4 * kMaxAcceleration * kRobotStep_s);
    yaw_rad_ += w_radps_ * kRobotStep_s;
    x_m_ += v_mps_ * std::cos(yaw_rad_) * kRobotStep_s;
    y_m_ += v_mps_ * std::sin(yaw_rad_) * kRobotStep_s;
    driven_m_ += std::abs(v_mps_) * kRobotStep_s;
  }
  time_s_ += steps * kRobotStep_s;
}

double SimulatedRobot::support_m(const sim::Scene& scene, double x_m, double y_m) const
{
  double top = scene.ground().height_m(x_m, y_m);
  const double most = top + body_.climbs_m;
  std::vector<sim::Span> objects;
  scene.column(x_m, y_m, objects);
  for (const auto& o : objects)
    if (o.enter_m <= top + 0.01 && o.exit_m <= most) top = std::max(top, o.exit_m);
  return top;
}

/** A wheel rolls over edges: the height of its lowest point is given by all it touches. */
double SimulatedRobot::wheel_m(const sim::Scene& scene, double forward_m, double left_m) const
{
  const double c = std::cos(yaw_rad_), s = std::sin(yaw_rad_), r = body_.wheel_radius_m;
  double height = -HUGE_VAL;
  for (int i = -3; i <= 3; i++)
  {
    const double d = 0.3 * i * r;
    const double f = forward_m + d;
    const double support = support_m(scene, x_m_ + c * f - s * left_m, y_m_ + s * f + c * left_m);
    height = std::max(height, support + std::sqrt(r * r - d * d) - r);
  }
  return height;
}

Pose SimulatedRobot::T_map_base() const
{
  const sim::Scene scene(world_, time_s_);
  const double half = 0.5 * world_.robot.wheelbase_m, side = 0.5 * world_.robot.track_m;
  const double fl = wheel_m(scene, half, side), fr = wheel_m(scene, half, -side);
  const double rl = wheel_m(scene, -half, side), rr = wheel_m(scene, -half, -side);
  const double c = std::cos(yaw_rad_), s = std::sin(yaw_rad_);
  const sim::Vec3 forward = sim::normalized({c, s, (fl + fr - rl - rr) / (4 * half)});
  const sim::Vec3 sideways{-s, c, (fl + rl - fr - rr) / (4 * side)};
  const sim::Vec3 up = sim::normalized(sim::cross(forward, sideways));
  const sim::Vec3 at{x_m_, y_m_, 0.25 * (fl + fr + rl + rr)};
  return sim::pose_from_axes(forward, sim::cross(up, forward), up, at);
}

Pose SimulatedRobot::T_map_base_estimated() const
{
  sim::Random random(sim::mix(seed_, static_cast<std::uint64_t>(std::llround(time_s_ * 1e6))));
  const auto error = [&](double sigma) { return sigma * random.normal(); };
  const sim::Vec3 shift{
      error(noise_.position_m), error(noise_.position_m), error(noise_.position_m)};
  const double roll = error(noise_.angle_rad), pitch = error(noise_.angle_rad);
  const Pose turn = sim::pose_from_rpy({0, 0, 0}, roll, pitch, error(noise_.angle_rad));
  Pose T = sim::compose(T_map_base(), turn);
  T.m[3] += shift.x;
  T.m[7] += shift.y;
  T.m[11] += shift.z;
  return T;
}

sim::Scan SimulatedRobot::scan() const
{
  sim::Sweep sweep;
  sweep.time_s = time_s_;
  const Pose T_map_sensor = sim::compose(T_map_base(), world_.sensors[0].T_base_sensor);
  sweep.T_map_sensor = [T_map_sensor](double) { return T_map_sensor; };
  sweep.seed = sim::mix(seed_ ^ 0x5CA9, static_cast<std::uint64_t>(std::llround(time_s_ * 1e6)));
  return sim::take_scan(world_, scanner_, sweep);
}

/** Whether the ground around a place, where nothing stands, is farther below that under the middle
 * of the robot than above it. Its wheels are no measure: they have climbed what it hit. */
bool SimulatedRobot::is_drop(double x_m, double y_m) const
{
  constexpr double kAround_m = 0.25;
  const sim::Scene scene(world_, time_s_);
  const double here_m = support_m(scene, x_m_, y_m_);
  double lowest_m = 0, highest_m = 0;
  for (int i = 0; i < 8; i++)
  {
    const double x = x_m + kAround_m * std::cos(i * sim::kPi / 4);
    const double y = y_m + kAround_m * std::sin(i * sim::kPi / 4);
    const double above_m = scene.floor_m(x, y, here_m + body_.steps_m) - here_m;
    lowest_m = std::min(lowest_m, above_m);
    highest_m = std::max(highest_m, above_m);
  }
  return -lowest_m > highest_m;
}

Contact SimulatedRobot::contact() const
{
  sim::TruthOptions options;
  options.clearance_m = body_.height_m;
  options.min_obstacle_m = body_.climbs_m;
  options.max_step_m = body_.steps_m;
  options.samples = 3;
  const sim::Bounds here{{x_m_, y_m_, 0}, {x_m_, y_m_, 0}};
  const double reach = 0.5 * std::hypot(body_.length_m, body_.width_m);
  const auto truth =
      sim::truth(world_, sim::window_around(here, reach, kTruthCell_m), time_s_, options);
  const double c = std::cos(yaw_rad_), s = std::sin(yaw_rad_);
  for (int iy = 0; iy < truth.window.cells_y; iy++)
    for (int ix = 0; ix < truth.window.cells_x; ix++)
    {
      const auto cell = static_cast<std::size_t>(iy * truth.window.cells_x + ix);
      if (truth.label[cell] != 0) continue;
      const double dx = truth.window.min_x_m + (ix + 0.5) * kTruthCell_m - x_m_;
      const double dy = truth.window.min_y_m + (iy + 0.5) * kTruthCell_m - y_m_;
      if (std::abs(c * dx + s * dy) > 0.5 * body_.length_m ||
          std::abs(-s * dx + c * dy) > 0.5 * body_.width_m)
        continue;
      const bool stands = truth.obstacle_top[cell] - truth.ground[cell] > body_.climbs_m;
      return !stands && is_drop(x_m_ + dx, y_m_ + dy) ? Contact::Drop : Contact::Obstacle;
    }
  return Contact::None;
}

}  // namespace talus::nav
