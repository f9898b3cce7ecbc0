#include "options.h"

#include "../../common/command_line.h"
#include "results.h"

#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

namespace talus::nav
{
namespace
{
constexpr const char* kFooter =
    "Each 0.1 s: scan -> map -> costmap -> route -> reactive navigator of MRPT -> robot.\n"
    "Collisions are judged by the truth of the world. Writes into DIR: path.csv (a row a step),\n"
    "navigation.png, frames/ (animation), map.tif (the map at the end), log.reactivenavlog (for\n"
    "navlog-viewer), summary.json.\n"
    "\n"
    "Examples:\n"
    "  talus-nav datasets/worlds/nav_indoor.yaml --goal 15,0 --scanner OS0-128 --output out\n"
    "  talus-nav datasets/worlds/nav_woods.yaml --goal 16,0 --planner 3d --seed 7 --output out\n"
    "  talus-nav datasets/worlds/nav_indoor.yaml --goal 15,0 --map octomap --output out\n"
    "  talus-nav datasets/worlds/nav/nav_shaft.yaml --goal 9,0 --scanner OS0-128 \\\n"
    "      --mount 0,0,0.68,0,15,0 --output out\n"
    "\n"
    "Exit codes: 0 arrived, 1 failed, 2 wrong usage, 3 blocked (there is no way), 4 collision, 5 "
    "timeout,\n"
    "6 fall (over an edge), 128 + N stopped by signal N.";

std::vector<double> goal_from(const std::string& text)
{
  const auto comma = text.find(',');
  std::vector<double> goal;
  for (const std::string& number :
       {text.substr(0, comma), comma == std::string::npos ? "" : text.substr(comma + 1)})
    if (const auto value = number_from(number); value && std::abs(*value) <= kFarthest_m)
      goal.push_back(*value);
  if (goal.size() != 2)
    throw CLI::ValidationError(
        "--goal", "'" + text + "' is not X,Y: two numbers with a comma, at most " +
                      number_text(kFarthest_m) + " m, such as 16,0");
  return goal;
}

/** "VLP-16" and "vlp16" are the same scanner. */
std::string plain(std::string name)
{
  name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
  return CLI::detail::to_lower(name);
}

void add_mission(CLI::App& app, Options& o)
{
  app.add_option("WORLD", o.world, "World file (.yaml); the robot starts where its way begins")
      ->required()
      ->type_name("");
  app.add_option_function<std::string>(
         "--goal", [&o](const std::string& text) { o.goal = goal_from(text); },
         "Where to go, map frame [m]; the robot has arrived when its middle is within " +
             number_text(MissionOptions().arrived_m) + " m of it")
      ->required()
      ->type_name("X,Y");
  app::add_text(app, "--output", o.output, "DIR", "Folder of the results")->required();
  app.add_option_function<std::string>(
         "--planner", [&o](const std::string& text) { o.in_3d = text == "3d"; },
         "2d: CReactiveNavigationSystem, 3d: CReactiveNavigationSystem3D (default: 2d)")
      ->check(CLI::IsMember({"2d", "3d"}))
      ->type_name("NAME");
  app::add_checked(
      app, "--map", o.map,
      "Where obstacles come from: talus; octomap or onesurface (an elevation map) to compare",
      "NAME", CLI::IsMember({"talus", "octomap", "onesurface"}))
      ->capture_default_str();
  app::add_text(
      app, "--planner-config", o.config, "FILE.ini",
      "INI file of navigator, map and obstacles (default: reactive2d_config.ini or "
      "reactive3d_config.ini of datasets/configs, built in)");
  app::add_number(
      app, "--timeout", o.timeout_s, 1.0, 1e5, "S", "Give up after this simulated time [s]");
}

void add_sensor(CLI::App& app, Options& o)
{
  std::vector<std::string> names;
  for (const auto& s : sim::scanners()) names.push_back(s.name);
  app.add_option(
         "--scanner", o.scanner, "Instead of the world's: " + CLI::detail::join(names, ", "))
      ->transform(CLI::IsMember(names, plain))
      ->type_name("NAME");
  app::add_mounting(
      app, "--mount", o.mount,
      "Where and how, instead of the world's, from the ground below the robot's middle (a positive "
      "pitch looks down)");
  app.add_flag_callback(
      "--drop-table", [&o] { throw CLI::CallForVersion(drop_table(o.mount), 0); },
      "Print which holes each scanner finds in time, at which speed, and where ahead it sees what "
      "is as high as the robot; and exit");
}

void add_noise(CLI::App& app, Options& o)
{
  app::add_checked(app, "--seed", o.seed, "Seed of all noise", "N", app::whole_of_64_bits())
      ->capture_default_str();
  app::add_number(
      app, "--noise", o.noise.range_m, 0.0, 1.0, "M", "Standard deviation of a range [m]");
  app::add_number(
      app, "--pose-noise", o.noise.position_m, 0.0, 1.0, "M", "Of each pose in x, y, z [m]");
  app::add_number(
      app, "--angle-noise", o.noise.angle_rad, 0.0, 1.0, "RAD",
      "Of each pose in roll, pitch, yaw [rad]");
}

void add_processing(CLI::App& app, Options& o)
{
  app.add_option_function<std::string>(
         "--backend", [&o](const std::string& text) { o.backend = backend_from_text(text); },
         "Of the map: auto, cpu or cuda (default: auto)")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}, CLI::ignore_case))
      ->type_name("NAME");
  app::add_number(app, "--threads", o.threads, 0, 1024, "N", "Of the CPU backend, 0: all cores");
  app::add_number(
      app, "--every", o.every, 0, 1000000, "N",
      "A frame of the animation each so many steps, 0: none");
  app.add_flag("--quiet", o.quiet, "Print errors only");
}
}  // namespace

void fit_sensor(sim::SensorSetup& sensor, const Options& o)
{
  if (!o.scanner.empty()) sensor.scanner = o.scanner;
  if (!o.mount) return;
  const app::Mounting& m = *o.mount;
  sensor.T_base_sensor = sim::pose_from_rpy(
      {m[0], m[1], m[2]}, sim::radians(m[5]), sim::radians(m[4]), sim::radians(m[3]));
}

void add_options(CLI::App& app, Options& options)
{
  app.description(
      "Drives a simulated robot to a goal: LiDAR -> terrain map -> MRPT's planners, no display.");
  add_mission(app, options);
  add_sensor(app, options);
  add_noise(app, options);
  add_processing(app, options);
  app.footer(kFooter);
}

}  // namespace talus::nav
