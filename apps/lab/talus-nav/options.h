#pragma once
#include "../../common/command_line.h"
#include "mission.h"

#include <talus/elevation_mapper.h>

#include <optional>
#include <string>

namespace CLI
{
class App;
}

namespace talus::nav
{
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

}  // namespace talus::nav
