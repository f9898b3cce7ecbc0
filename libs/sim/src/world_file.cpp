#include <talus/input_file.h>
#include <talus/sim/scanner.h>
#include <yaml-cpp/depthguard.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "only_document.h"
#include "world_parts.h"

namespace talus::sim
{
namespace
{
RobotSetup parse_robot(const Fields& f)
{
  constexpr double kLongest_m = 1e5;  // the curve is kept in pieces of 2 cm
  RobotSetup r;
  double way_m = 0;
  for (const auto& p : f.rows("path_m", 2))
  {
    const Vec3 next{p[0], p[1], 0};
    if (!r.waypoints.empty())
    {
      const double leg_m = norm(next - r.waypoints.back());
      if (leg_m < 1e-3) f.fail("path_m", "holds the same place twice in a row");
      way_m += leg_m;
    }
    r.waypoints.push_back(next);
  }
  if (way_m > kLongest_m) f.fail("path_m", "is longer than 100 km: shorten it");
  r.yaw_rad = radians(f.number_or("yaw_deg", 0, kAny));
  r.speed_mps = f.number_or("speed_mps", 1, kPositive);
  r.duration_s = f.number_or("duration_s", 0, kPositive);
  r.wheelbase_m = f.number_or("wheelbase_m", r.wheelbase_m, kPositive);
  r.track_m = f.number_or("track_m", r.track_m, kPositive);
  return r;
}

SensorSetup parse_sensor(const Fields& f)
{
  SensorSetup s;
  s.scanner = f.text_or("scanner", s.scanner);
  std::vector<std::string> names;
  for (const Scanner& known : scanners()) names.push_back(known.name);
  if (!find_scanner(s.scanner))
  {
    std::string list;
    for (const auto& n : names) list += (list.empty() ? "" : ", ") + n;
    f.fail(
        "scanner", "'" + s.scanner + "' is not known, did you mean '" +
                       nearest_word(s.scanner, names) + "'? Known: " + list);
  }
  const auto at = f.numbers_or("at_m", {0, 0, 0.68}, kAny);
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

void check_way(const Fields& f, const Mover& mover, const World& world)
{
  const auto fail = [&](const char* into, const Collision& c, const char* remedy)
  {
    std::ostringstream what;
    what << std::fixed << std::setprecision(1) << "leads into " << into << ": at (" << c.x_m << ", "
         << c.y_m << ") after " << c.time_s << " s; " << remedy;
    f.fail("path", what.str());
  };
  if (const auto thing = first_collision(mover, world))
    fail("an object", *thing, "lead it around, or move the object");
  if (const auto robot = first_meeting(mover, world))
    fail("the robot", *robot, "lead it around, or let it come earlier or later");
}

Mover parse_mover(const Fields& f, bool person)
{
  Mover m;
  for (const auto& row : f.rows("path", 3))
  {
    if (!m.path.empty() && row[0] <= m.path.back().time_s)
      f.fail("path", "must be a list of [t_s, x_m, y_m] with ascending times");
    m.path.push_back({row[0], row[1], row[2]});
  }
  const double lift = f.number_or("lift_m", 0, kNotNegative);
  // What stands reaches a little into the ground, so that nothing shows under it on rough ground.
  const double bottom = lift > 0 ? lift : -0.05;
  if (person)
  {
    const double height = f.number_or("height_m", 1.75, kPositive);
    m.shapes = {make_cylinder(
        {0, 0, bottom}, {0, 0, lift + height}, f.number_or("radius_m", 0.25, kPositive))};
  }
  else
  {
    const auto size = f.numbers("size_m", 3, kPositive);
    m.shapes = {make_box({0, 0, bottom}, {size[0], size[1], size[2] + lift - bottom}, 0)};
  }
  m.shapes[0].reflectivity = f.number_or("reflectivity", 0.8, kShare);
  return m;
}

std::string stem(const std::string& file) { return std::filesystem::path(file).stem().string(); }

}  // namespace

std::vector<Mover> parse_movers(const YAML::Node& list, const std::string& file, const World& world)
{
  if (!list.IsSequence())
    fail_at(list, file, "movers", "must be a list of movers, e.g. `- person: {...}`");
  require_few(list, file, "movers", 1000);
  std::vector<Mover> movers;
  for (const auto& entry : list)
  {
    const std::string name = only_key(entry, file, "movers", {"person", "box"});
    const bool person = name == "person";
    const std::vector<std::string> keys =
        person ? std::vector<std::string>{"path", "height_m", "radius_m", "lift_m", "reflectivity"}
               : std::vector<std::string>{"path", "size_m", "lift_m", "reflectivity"};
    const Fields fields(entry[name], file, "movers." + name, keys);
    movers.push_back(parse_mover(fields, person));
    check_way(fields, movers.back(), world);
  }
  return movers;
}

namespace
{
std::string at_line(const std::string& file, const YAML::Exception& e)
{
  return file + ":" + std::to_string(std::max(1, e.mark.line + 1)) + ": ";
}

World world_from(const YAML::Node& root, const std::string& file)
{
  const Fields f(
      root, file, "world",
      {"name", "description", "seed", "ground", "objects", "movers", "robot", "sensor"});
  World w;
  w.name = f.text_or("name", stem(file));
  w.description = f.text_or("description", "");
  w.seed = static_cast<std::uint64_t>(f.whole_or("seed", 1, 0, 2000000000));
  w.ground = parse_ground(f.node("ground"), file);
  w.robot = parse_robot(Fields(
      f.node("robot"), file, "robot",
      {"path_m", "yaw_deg", "speed_mps", "duration_s", "wheelbase_m", "track_m"}));
  if (f.has("sensor"))
    w.sensor = parse_sensor(Fields(
        f.node("sensor"), file, "sensor",
        {"scanner", "at_m", "roll_pitch_yaw_deg", "noise_m", "noise_per_m", "dropout", "rate_hz",
         "max_range_m", "motion_distortion"}));
  else
    w.sensor.T_base_sensor = pose_from_rpy({0, 0, 0.68}, 0);
  if (f.has("objects"))
    w.objects =
        ShapeTree(parse_objects(f.node("objects"), file, w.ground, RobotPath(w.robot, w.ground)));
  if (f.has("movers")) w.movers = parse_movers(f.node("movers"), file, w);
  return w;
}

}  // namespace

World parse_world(const std::string& text, const std::string& file)
{
  try
  {
    return world_from(only_document(text, file), file);
  }
  catch (const YAML::DeepRecursion& e)  // yaml-cpp calls it a "bad file"
  {
    throw std::runtime_error(at_line(file, e) + "lists and maps are nested too deeply");
  }
  catch (const YAML::Exception& e)
  {
    throw std::runtime_error(at_line(file, e) + "not valid YAML: " + e.msg);
  }
}

World load_world(const std::string& path)
{
  constexpr std::uint64_t kMost_bytes = 1
                                        << 20;  // takes a hundred times as much memory once parsed
  return parse_world(read_input_file(path, "world file", kMost_bytes), path);
}

}  // namespace talus::sim
