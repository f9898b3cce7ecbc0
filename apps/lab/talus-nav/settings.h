#pragma once
#include "options.h"

#include <talus/mrpt/obstacles.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace talus::nav
{
constexpr double kCostmapCell_m = 0.05;  //!< of the route; the map has the same cells

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

}  // namespace talus::nav
