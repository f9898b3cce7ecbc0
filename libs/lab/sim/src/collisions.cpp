#include <algorithm>
#include <cmath>

#include "world_parts.h"

namespace talus::sim
{
namespace
{
constexpr double kStep_m = 0.1;  //!< along the path
constexpr double kMaxSteps = 10000;  //!< from one stop to the next, however far that is
constexpr double kGrid_m = 0.025;  //!< of vertical lines through what two bodies may share
constexpr double kMaxLines = 100;  //!< along each axis
constexpr double kOver_m = 0.2;  //!< what is lower, a mover steps or rides over
constexpr double kGraze_m = 0.01;  //!< less of a line in both is no collision

/** What the bounds of two bodies share; empty where a minimum is not below its maximum. */
Bounds shared(const Bounds& a, const Bounds& b)
{
  return {
      {std::max(a.min_m.x, b.min_m.x), std::max(a.min_m.y, b.min_m.y),
       std::max(a.min_m.z, b.min_m.z)},
      {std::min(a.max_m.x, b.max_m.x), std::min(a.max_m.y, b.max_m.y),
       std::min(a.max_m.z, b.max_m.z)}};
}

/** Whether two bodies overlap on the vertical line at (x, y), above a height. */
bool overlap_at(const Shape& a, const Shape& b, double x_m, double y_m, double above_m)
{
  std::vector<Span> of_a, of_b;
  column(a, x_m, y_m, of_a);
  column(b, x_m, y_m, of_b);
  if (of_a.empty() || of_b.empty()) return false;
  const double low = std::max({of_a[0].enter_m, of_b[0].enter_m, above_m});
  return std::min(of_a[0].exit_m, of_b[0].exit_m) > low + kGraze_m;
}

bool overlap(const Shape& a, const Shape& b, double above_m)
{
  const Bounds area = shared(bounds(a), bounds(b));
  const double size_x = area.max_m.x - area.min_m.x, size_y = area.max_m.y - area.min_m.y;
  if (size_x <= 0 || size_y <= 0 || area.max_m.z <= std::max(area.min_m.z, above_m)) return false;
  const double nx = std::ceil(std::min(size_x / kGrid_m, kMaxLines));
  const double ny = std::ceil(std::min(size_y / kGrid_m, kMaxLines));
  for (double i = 0.5; i < nx; ++i)
    for (double j = 0.5; j < ny; ++j)
    {
      const double x = area.min_m.x + size_x * i / nx, y = area.min_m.y + size_y * j / ny;
      if (overlap_at(a, b, x, y, above_m)) return true;
    }
  return false;
}

/** Times at which a mover has gone one step after the other. */
std::vector<double> times_along(const std::vector<Mover::Stop>& path)
{
  std::vector<double> times{path[0].time_s};
  for (std::size_t i = 1; i < path.size(); ++i)
  {
    const Mover::Stop &a = path[i - 1], &b = path[i];
    const double path_m = std::hypot(b.x_m - a.x_m, b.y_m - a.y_m);
    const double steps = std::clamp(std::ceil(path_m / kStep_m), 1.0, kMaxSteps);
    for (double s = 1; s <= steps; ++s)
      times.push_back(a.time_s + (b.time_s - a.time_s) * s / steps);
  }
  return times;
}

/** A mover at one time. */
struct Placed
{
  Placed(const Mover& mover, double at_s, const Ground& ground)
      : time_s(at_s), at(mover.on_ground(at_s, ground)), bodies(mover.placed(at))
  {
  }
  bool meets(const Shape& thing) const
  {
    return std::any_of(
        bodies.begin(), bodies.end(),
        [&](const Shape& body)
        {
          return body.is_there(time_s) && thing.is_there(time_s) &&
                 overlap(body, thing, at.z() + kOver_m);
        });
  }
  Collision collision() const { return {time_s, at.x(), at.y()}; }

  double time_s;
  Pose at;
  std::vector<Shape> bodies;
};

/** The robot: a box over its wheels, as high as its highest sensor. */
Shape body_of_robot(const World& world)
{
  const RobotSetup& r = world.robot;
  double height_m = kOver_m;
  for (const SensorSetup& s : world.sensors) height_m = std::max(height_m, s.T_base_sensor.z());
  return make_box({0, 0, 0}, {r.wheelbase_m, r.track_m, height_m}, 0);
}

/** Times during the drive at which robot or mover has gone one step after the other. */
std::vector<double> times_of_drive(
    const RobotPath& path, const RobotSetup& robot, const Mover& mover)
{
  const double path_s = path.path_s();
  const double end_s = path.duration_s();
  std::vector<double> times{0};
  for (double t : times_along(mover.path))
    if (t > 0 && t < end_s) times.push_back(t);
  const double step_s = std::max(kStep_m / robot.speed_mps, path_s / kMaxSteps);
  for (double i = 1; i * step_s < std::min(path_s, end_s); ++i) times.push_back(i * step_s);
  times.push_back(end_s);
  std::sort(times.begin(), times.end());
  return times;
}

}  // namespace

std::optional<Collision> first_collision(const Mover& mover, const World& world)
{
  for (const double time_s : times_along(mover.path))
  {
    const Placed placed(mover, time_s, world.ground_at(time_s));
    for (const Shape& thing : world.objects.shapes())
      if (thing.mean_free_path_m == 0 && placed.meets(thing)) return placed.collision();
  }
  return std::nullopt;
}

std::optional<Collision> first_meeting(const Mover& mover, const World& world)
{
  const RobotPath path(world);
  const Shape body = body_of_robot(world);
  for (const double time_s : times_of_drive(path, world.robot, mover))
  {
    const Placed placed(mover, time_s, world.ground_at(time_s));
    Shape robot = body;
    robot.T_map_shape = compose(path.T_map_base(time_s), body.T_map_shape);
    if (placed.meets(robot)) return placed.collision();
  }
  return std::nullopt;
}

}  // namespace talus::sim
