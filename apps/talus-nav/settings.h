#pragma once
#include "options.h"

#include <talus/mrpt/obstacles.h>

#include <memory>
#include <string>

namespace talus::nav
{
/** One INI file: the sections of MRPT's navigator, of the map and [talus_obstacles]. */
struct Settings
{
  std::string ini;  //!< its text
  Parameters parameters;
  ObstacleOptions obstacles;
};

/** Throws std::runtime_error that says what is wrong with which file. */
Settings load_settings(const Options& options);

std::unique_ptr<MapSource> make_source(const Options& options, const Settings& settings);

}  // namespace talus::nav
