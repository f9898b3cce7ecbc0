#pragma once
#include "../../common/command_line.h"
#include "mission.h"

#include <talus/elevation_mapper.h>
#include <talus/mrpt/obstacles.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace CLI
{
class App;
}

namespace talus::nav
{
constexpr double kCostmapCell_m = 0.05;  //!< of the route; the map has the same cells
constexpr double kFarthest_m = 3000;  //!< from the origin: what OctoMap can hold

/** What the command line says. */
struct Options
{
  std::string world, output;
  std::vector<double> goal;  //!< x, y
  bool in_3d = false;
  std::string map = "talus";  //!< or octomap, onesurface
  std::string scanner;  //!< empty: as the world says
  std::optional<app::Mounting> mount;  //!< empty: as the world says
  std::string config;  //!< INI file of the planner, empty: the built-in one
  std::uint64_t seed = 1;
  Noise noise;
  Backend backend = Backend::Auto;
  int threads = kAllCores;
  double timeout_s = 180;
  int every = 10;  //!< a frame of the animation each so many steps; 0: none
  bool quiet = false;
};

/** Makes the sensor of a world what the options say. */
void fit_sensor(sim::SensorSetup& sensor, const Options& options);

/** Adds the options, the description and the footer of the command. */
void add_options(CLI::App& app, Options& options);

/** One INI file: the sections of MRPT's navigator, of the map and [talus_obstacles]. */
struct Settings
{
  std::string name;  //!< of the file, for messages
  std::string ini;  //!< its text
  Parameters parameters;
  talus::ObstacleOptions obstacles;
};

/** A file that cannot be read, or with which MRPT's navigator cannot work: its name, what is wrong
 * and what to do. */
struct WrongConfiguration : std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/** Throws WrongConfiguration. */
Settings load_settings(const Options& options);

std::unique_ptr<MapSource> make_source(
    const Options& options, const Settings& settings, const RobotBody& body);

/** Covers start, goal and all that stands in the world, and is unknown. Throws
 * std::invalid_argument where that is too far away or too large. */
Costmap start_costmap(const sim::World& world, const Point2& start, const Point2& goal);

}  // namespace talus::nav
