// talus-nav: a robot, its LiDAR, the map and MRPT's planners in a closed loop, without a display.
#include "../common/interrupt.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "picture.h"
#include "results.h"
#include "settings.h"

#include <talus/io/geotiff.h>
#include <talus/io/mrpt_error.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>

namespace fs = std::filesystem;
using namespace talus::nav;

namespace
{
enum ExitCode
{
  kFailed = 1,
  kUsage = 2
};

int exit_code(Ending ending)
{
  switch (ending)
  {
    case Ending::Arrived:
      return 0;
    case Ending::Blocked:
      return 3;
    case Ending::Collision:
      return 4;
    default:
      return 5;
  }
}

/** Where the robot is and how it goes, for the pictures. */
std::string title(const Options& o, const MissionResult& m, bool ended)
{
  char text[200];
  std::snprintf(
      text, sizeof text, "%s, %s planner, %s, seed %llu: %.1f s%s%s",
      talus::app::name_of_world(o.world).c_str(), o.in_3d ? "3D" : "2D",
      o.octomap ? "octomap" : "talus", static_cast<unsigned long long>(o.seed),
      ended ? m.time_s : m.steps.back().time_s, ended ? ", " : "",
      ended ? ending_name(m.ending).c_str() : "");
  return text;
}

std::string frame_path(const std::string& folder, std::size_t step)
{
  char name[40];
  std::snprintf(name, sizeof name, "frame_%06zu.png", step);
  return (fs::path(folder) / "frames" / name).string();
}

/** The navigator's log gets a name that does not depend on its number. */
void rename_log(const fs::path& folder)
{
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".reactivenavlog")
      return fs::rename(entry.path(), folder / "log.reactivenavlog");
}

MissionResult drive(
    const Options& o, const Settings& settings, const std::string& folder,
    const talus::app::Interrupt& interrupt)
{
  const auto world = talus::sim::load_world(o.world);
  SimulatedRobot robot(world, o.noise, o.seed);
  if (robot.collides())
    throw std::runtime_error(o.world + ": the robot starts in an obstacle; move path_m");
  MissionOptions mission_options;
  mission_options.goal = {o.goal[0], o.goal[1]};
  mission_options.timeout_s = o.timeout_s;
  Route route(
      world, {robot.x_m(), robot.y_m()}, mission_options.goal, kCostmapCell_m,
      mission_options.robot_radius_m);
  const auto map = make_source(o, settings);
  const fs::path cache = fs::path(folder) / "cache";
  fs::create_directories(cache);
  fs::create_directories(fs::path(folder) / "frames");
  Pilot pilot(robot, *map, o.in_3d, settings, folder, cache.string());
  Painter painter(world, robot.body(), mission_options);
  const auto on_step = [&](const MissionResult& m)
  {
    interrupt.check();
    if (o.every > 0 && m.steps.size() % static_cast<std::size_t>(o.every) == 1 % o.every)
      write_picture(
          frame_path(folder, m.steps.size()), painter.draw(m, route, pilot, title(o, m, false)));
  };
  const auto result = run_mission(world, robot, *map, pilot, route, mission_options, on_step);
  write_results(folder, o, result, painter.draw(result, route, pilot, title(o, result, true)));
  if (map->terrain())
    talus::io::write_geotiff(
        (fs::path(folder) / "map.tif").string(), talus::io::snapshot(*map->terrain()));
  fs::remove_all(cache);
  return result;
}

int run(const Options& o, const Settings& settings)
{
  const talus::app::Interrupt interrupt;
  talus::app::OutputFolder output(o.output);
  MissionResult result;
  try
  {
    result = drive(o, settings, output.staging(), interrupt);
  }
  catch (const WrongConfiguration&)
  {
    throw;
  }
  catch (const std::invalid_argument& e)  // map or route cannot work with the world's numbers
  {
    throw std::runtime_error(o.world + ": " + e.what());
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(output.told(talus::io::reason_of(e)));
  }
  rename_log(output.staging());
  interrupt.check();
  output.commit();
  if (!o.quiet) std::cout << console_summary(o, result);
  return exit_code(result.ending);
}

int fail(const std::string& what, int code)
{
  std::cerr << "talus-nav: " << what << "\n";
  return code;
}
}  // namespace

int main(int argc, char** argv)
{
  Options options;
  if (const auto code = parse_options(argc, argv, options)) return *code;
  if (options.quiet) std::clog.setstate(std::ios::failbit);  // tells which backend was taken
  try
  {
    return run(options, load_settings(options));
  }
  catch (const talus::app::Interrupted& e)
  {
    return fail("stopped; nothing was written", 128 + e.signal);
  }
  catch (const WrongConfiguration& e)
  {
    return fail(e.what(), kUsage);
  }
  catch (const std::exception& e)
  {
    return fail(talus::io::reason_of(e), kFailed);
  }
}
