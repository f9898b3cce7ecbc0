// talus-nav: a robot, its LiDAR, the map and MRPT's planners in a closed loop, without a display.
#include "../../common/child_process.h"
#include "../../common/crash_context.h"
#include "../../common/log_name.h"
#include "../../common/output_folder.h"
#include "../../common/progress_bar.h"
#include "../../common/run_app.h"
#include "picture.h"
#include "results.h"

#include <talus/io/geotiff.h>
#include <talus/io/atomic_file.h>
#include <talus/io/map_picture.h>
#include <talus/io/mrpt_error.h>
#include <talus/number_text.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>

namespace fs = std::filesystem;
using namespace talus::nav;
using talus::app::print_error;

namespace
{
enum ExitCode
{
  kFailed = 1,
  kUsage = 2
};

constexpr const char* kSimplerWorld = "Try a world with fewer things in it, and a nearer --goal";

/** Where the robot is and how it goes, for the pictures. */
std::string title(const Options& o, const MissionResult& m, bool ended)
{
  char text[200];
  std::snprintf(
      text, sizeof text, "%s, %s planner, %s, seed %llu: %s%.1f s%s%s",
      talus::app::name_of_world(o.world).c_str(), o.in_3d ? "3D" : "2D", o.map.c_str(),
      static_cast<unsigned long long>(o.seed),
      ended ? (talus::fixed_text(m.driven_m, 1) + " m in ").c_str() : "",
      ended ? m.time_s : m.steps.back().time_s, ended ? ", " : "",
      ended ? info_of(m.ending).name : "");
  return text;
}

std::string frame_path(const std::string& folder, std::size_t step)
{
  char name[40];
  std::snprintf(name, sizeof name, "frame_%06zu.png", step);
  return (fs::path(folder) / "frames" / name).string();
}

/** The navigator's log, closed by now, is checked: MRPT does not tell when its end does not reach
 * the disk. It gets a name that does not depend on its number. */
void finish_log(const fs::path& folder)
{
  const fs::path name = folder / "log.reactivenavlog";
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == name.extension())
    {
      talus::io::require_complete_packed(entry.path().string(), name.string());
      return fs::rename(entry.path(), name);
    }
}

void tell_unseen(
    const std::string& world, const talus::sim::SensorSetup& sensor, double clearance_m)
{
  const auto ray = highest_ray(*talus::sim::find_scanner(sensor.scanner), sensor.T_base_sensor);
  if (const auto unseen = talus::hints::unseen_ahead(ray, clearance_m))
    print_error("hint: " + world + ": " + *unseen);
}

double goal_distance_m(const MissionOptions& mission, double x_m, double y_m)
{
  return std::hypot(mission.goal.x_m - x_m, mission.goal.y_m - y_m);
}

MissionResult drive(const Options& o, const Settings& settings, const std::string& folder)
{
  const talus::app::CrashContext context(o.world, kSimplerWorld);
  auto world =
      talus::app::guarded(o.world, kSimplerWorld, [&] { return talus::sim::load_world(o.world); });
  fit_sensor(world.sensors[0], o);
  SimulatedRobot robot(world, o.noise, o.seed);
  if (robot.contact() != Contact::None)
    throw std::runtime_error(
        o.world + ": the robot starts in an obstacle or over an edge; move path_m");
  if (!o.quiet) tell_unseen(o.world, world.sensors[0], settings.parameters.clearance_m);
  MissionOptions mission_options;
  mission_options.goal = {o.goal[0], o.goal[1]};
  mission_options.timeout_s = o.timeout_s;
  const auto map = make_source(o, settings, robot.body());
  Planner planner(
      robot.body().footprint(),
      start_costmap(world, {robot.x_m(), robot.y_m()}, mission_options.goal));
  const fs::path cache = fs::path(folder) / "cache";
  fs::create_directories(cache);
  fs::create_directories(fs::path(folder) / "frames");
  Pilot pilot(robot, *map, o.in_3d, settings, folder, cache.string());
  Painter painter(world, robot.body(), mission_options);
  talus::app::ProgressBar bar("talus-nav", !o.quiet);
  const double whole_m = goal_distance_m(mission_options, robot.x_m(), robot.y_m());
  const auto on_step = [&](const MissionResult& m)
  {
    const Step& at = m.steps.back();
    const double left_m = goal_distance_m(mission_options, at.x_m, at.y_m);
    bar.show(
        1 - left_m / whole_m, talus::fixed_text(at.time_s, 0) + " s, " +
                                  talus::fixed_text(left_m, 1) + " m from the goal");
    if (o.every > 0 && m.steps.size() % static_cast<std::size_t>(o.every) == 1 % o.every)
      talus::io::write_png(
          frame_path(folder, m.steps.size()), painter.draw(m, planner, pilot, title(o, m, false)));
  };
  auto result = run_mission(world, robot, *map, pilot, planner, mission_options, on_step);
  Options used = o;
  used.scanner = world.sensors[0].scanner;
  write_results(folder, used, result, painter.draw(result, planner, pilot, title(o, result, true)));
  if (map->terrain())
    talus::io::write_geotiff(
        (fs::path(folder) / "map.tif").string(), talus::io::snapshot(*map->terrain()));
  fs::remove_all(cache);
  return result;
}

/** In the child: the exit code. */
int drive_or_tell(
    const Options& o, const Settings& settings, const talus::app::OutputFolder& output)
{
  try
  {
    const MissionResult result = drive(o, settings, output.staging());
    finish_log(output.staging());
    if (!o.quiet) std::cout << console_summary(o, result);
    return info_of(result.ending).exit_code;
  }
  catch (const WrongConfiguration& e)
  {
    print_error(output.shown(e.what()));
    return kUsage;
  }
  catch (const std::invalid_argument& e)  // map or route cannot work with the world's numbers
  {
    print_error(o.world + ": " + e.what());
  }
  catch (const std::bad_alloc& e)
  {
    print_error(talus::app::failure_text(e, o.world, kSimplerWorld));
  }
  catch (const std::exception& e)
  {
    print_error(output.shown(talus::io::reason_of(e)));
  }
  return kFailed;
}

int run_with(const Options& o, const Settings& settings)
{
  talus::app::require_apart(
      o.output, {"navigation.png", "path.csv", "summary.json", "map.tif"}, {o.world, o.config});
  talus::app::OutputFolder output(o.output);
  // Numbers that make no sense can crash MRPT's navigators.
  const int code = talus::app::run_command_in_child(
      o.world, kSimplerWorld, [&] { return drive_or_tell(o, settings, output); }, print_error);
  if (code == kFailed || code == kUsage || talus::app::stop_signal()) return code;
  output.commit("summary.json");
  if (!o.quiet) std::cout << "  wrote " << (fs::path(o.output) / "navigation.png").string() << "\n";
  return code;
}

int run(const Options& o)
{
  if (o.quiet) std::clog.setstate(std::ios::failbit);  // tells which backend was taken
  try
  {
    return run_with(o, load_settings(o));
  }
  catch (const WrongConfiguration& e)
  {
    print_error(e.what());
    return kUsage;
  }
}
}  // namespace

int main(int argc, char** argv) { return talus::app::run_app("talus-nav", argc, argv, run); }
