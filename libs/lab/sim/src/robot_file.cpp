// The robot of a world file, its sensors, and the errors of its poses.
#include <talus/sim/scanner.h>

#include <algorithm>

#include "world_parts.h"

namespace talus::sim
{
namespace
{
std::vector<Vec3> parse_waypoints(const Fields& f)
{
  constexpr double kLongest_m = 1e5;  // the curve is kept in pieces of 2 cm
  std::vector<Vec3> waypoints;
  double length_m = 0;
  for (const auto& p : f.rows("path_m", 2))
  {
    const Vec3 next{p[0], p[1], 0};
    if (!waypoints.empty())
    {
      const double leg_m = norm(next - waypoints.back());
      if (leg_m < 1e-3) f.fail("path_m", "holds the same place twice in a row");
      length_m += leg_m;
    }
    waypoints.push_back(next);
  }
  if (length_m > kLongest_m) f.fail("path_m", "is longer than 100 km: shorten it");
  return waypoints;
}

std::vector<Lift> parse_lifts(const YAML::Node& list, const std::string& file)
{
  const std::string where = "robot.lifts";
  require_list(list, file, where, "{time_s: 5, duration_s: 6, z_m: 3}");
  std::vector<Lift> lifts;
  for (const auto& entry : list)
  {
    const Fields f(entry, file, where, "time_s duration_s z_m");
    const Lift lift{
        f.number("time_s", kNotNegative), f.number_or("duration_s", 0, kNotNegative),
        f.number("z_m", kAny)};
    if (!lifts.empty() && lift.time_s < lifts.back().time_s + lifts.back().duration_s)
      f.fail("time_s", "must not be before the end of the lift before it");
    lifts.push_back(lift);
  }
  return lifts;
}

std::vector<Shape> parse_body(const YAML::Node& list, const std::string& file)
{
  require_list(list, file, "robot.body", "box: {at_m: [0, 0, 0.2], size_m: [0.8, 0.5, 0.3]}");
  std::vector<Shape> body;
  for (const auto& entry : list)
  {
    const std::string name = only_key(entry, file, "robot.body", {"box", "post"});
    const bool box = name == "box";
    const Fields f(
        entry[name], file, "robot.body." + name,
        box ? "at_m size_m yaw_deg reflectivity" : "at_m height_m radius_m reflectivity");
    const Vec3 at = f.vector("at_m", kAny);
    if (box)
      body.push_back(
          make_box(at, f.vector("size_m", kPositive), radians(f.number_or("yaw_deg", 0, kAny))));
    else
      body.push_back(make_cylinder(
          at, at + Vec3{0, 0, f.number("height_m", kPositive)}, f.number("radius_m", kPositive)));
    body.back().reflectivity = f.number_or("reflectivity", 0.5, kShare);
  }
  return body;
}

void require_scanner(const Fields& f, const std::string& name)
{
  if (find_scanner(name)) return;
  std::vector<std::string> names;
  for (const Scanner& known : scanners()) names.push_back(known.name);
  f.fail("scanner", "'" + name + "' is not known" + known_words(name, names));
}

const std::string kSensorKeys =
    "scanner at_m roll_pitch_yaw_deg noise_m noise_per_m dropout rate_hz max_range_m "
    "motion_distortion";

SensorSetup sensor_of(const Fields& f)
{
  SensorSetup s;
  s.scanner = f.text_or("scanner", s.scanner);
  require_scanner(f, s.scanner);
  const auto at = f.numbers_or("at_m", {0, 0, s.T_base_sensor.z()}, kAny);
  const auto rpy = f.numbers_or("roll_pitch_yaw_deg", {0, 0, 0}, kAny);
  s.T_base_sensor =
      pose_from_rpy({at[0], at[1], at[2]}, radians(rpy[0]), radians(rpy[1]), radians(rpy[2]));
  if (f.has("noise_m")) s.noise_m = f.number("noise_m", kNotNegative);
  if (f.has("noise_per_m")) s.noise_per_m = f.number("noise_per_m", kNotNegative);
  if (f.has("dropout")) s.dropout = f.number("dropout", kShare);
  if (f.has("rate_hz")) s.rate_hz = f.number("rate_hz", kPositive);
  if (f.has("max_range_m")) s.max_range_m = f.number("max_range_m", kPositive);
  s.motion_distortion = f.flag_or("motion_distortion", false);
  return s;
}

PoseErrors::Jump jump_of(const Fields& f)
{
  const auto angle = [&](const char* key) { return radians(f.number_or(key, 0, kAny)); };
  return {
      f.number("time_s", kNotNegative),
      {f.number_or("x_m", 0, kAny), f.number_or("y_m", 0, kAny), f.number_or("z_m", 0, kAny)},
      angle("roll_deg"),
      angle("pitch_deg"),
      angle("yaw_deg")};
}

}  // namespace

RobotSetup parse_robot(const YAML::Node& node, const std::string& file)
{
  const Fields f(
      node, file, "robot", "path_m yaw_deg speed_mps duration_s wheelbase_m track_m lifts body");
  RobotSetup r;
  r.waypoints = parse_waypoints(f);
  r.yaw_rad = radians(f.number_or("yaw_deg", 0, kAny));
  r.speed_mps = f.number_or("speed_mps", 1, kPositive);
  r.duration_s = f.number_or("duration_s", 0, kPositive);
  r.wheelbase_m = f.number_or("wheelbase_m", r.wheelbase_m, kPositive);
  r.track_m = f.number_or("track_m", r.track_m, kPositive);
  if (f.has("lifts")) r.lifts = parse_lifts(f.node("lifts"), file);
  if (f.has("body")) r.body = parse_body(f.node("body"), file);
  return r;
}

SensorSetup parse_sensor(const YAML::Node& node, const std::string& file)
{
  return sensor_of(Fields(node, file, "sensor", kSensorKeys));
}

std::vector<SensorSetup> parse_sensors(const YAML::Node& list, const std::string& file)
{
  require_list(list, file, "sensors", "{name: front, scanner: VLP-16, at_m: [1, 0, 1]}");
  if (list.size() == 0) fail_at(list, file, "sensors", "must hold one sensor or more");
  require_max_size(list, file, "sensors", 100);
  std::vector<SensorSetup> sensors;
  for (const auto& entry : list)
  {
    const Fields f(entry, file, "sensors", kSensorKeys + " name phase_s");
    SensorSetup s = sensor_of(f);
    f.node("name");
    s.name = f.text_or("name", "");
    if (s.name.empty()) f.fail("name", "must not be empty");
    if (std::any_of(
            sensors.begin(), sensors.end(), [&](const auto& o) { return o.name == s.name; }))
      f.fail("name", "'" + s.name + "' is the name of another sensor: give each its own");
    s.phase_s = f.number_or("phase_s", 0, kNotNegative);
    sensors.push_back(s);
  }
  return sensors;
}

PoseErrors parse_poses(const YAML::Node& node, const std::string& file)
{
  const Fields f(node, file, "poses", "jumps drift_mps");
  PoseErrors errors;
  if (f.has("drift_mps"))
  {
    const Fields drift(f.node("drift_mps"), file, "poses.drift_mps", "x y z");
    errors.drift_mps = {
        drift.number_or("x", 0, kAny), drift.number_or("y", 0, kAny),
        drift.number_or("z", 0, kAny)};
  }
  if (!f.has("jumps")) return errors;
  const YAML::Node list = f.node("jumps");
  require_list(list, file, "poses.jumps", "{time_s: 5, z_m: 0.3, roll_deg: 1}");
  for (const auto& entry : list)
  {
    const Fields jump(entry, file, "poses.jumps", "time_s x_m y_m z_m roll_deg pitch_deg yaw_deg");
    errors.jumps.push_back(jump_of(jump));
    const auto n = errors.jumps.size();
    if (n > 1 && errors.jumps[n - 1].time_s < errors.jumps[n - 2].time_s)
      jump.fail("time_s", "must not be before that of the jump before it");
  }
  return errors;
}

}  // namespace talus::sim
