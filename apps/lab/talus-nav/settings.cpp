#include "settings.h"

#include "builtin_configs.h"
#include "planner_ini.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/format.h>
#include <talus/input_file.h>
#include <talus/io/mrpt_error.h>
#include <talus/mrpt/parameters_ini.h>

#include <cstdint>
#include <iostream>
#include <stdexcept>

namespace talus::nav
{
namespace
{
constexpr const char* kObstacles = "talus_obstacles";

std::string text_of(const std::string& path)
{
  constexpr std::uint64_t kMax_bytes = 1 << 20;  // the shipped files have 14 KB
  try
  {
    return read_input_file(path, "planner configuration (--planner-config)", kMax_bytes);
  }
  catch (const std::exception& e)
  {
    throw WrongConfiguration(e.what());
  }
}

/** Of the sections that are read by this project. */
void require_sound(const Settings& s)
{
  try
  {
    require_sound_ini(
        s.ini, s.name,
        {"CDualElevationMap_creationOpts", "CDualElevationMap_insertOpts", kObstacles});
  }
  catch (const std::exception& e)
  {
    throw WrongConfiguration(e.what());
  }
}

void require_navigator(const mrpt::config::CConfigFileBase& ini, const Options& o)
{
  const std::string section = planner_name(o.in_3d);
  if (ini.sectionExists(section)) return;
  throw std::runtime_error(
      "has no section [" + section + "]; --planner " + (o.in_3d ? "3d" : "2d") +
      " needs one such as in " + shipped_ini(o.in_3d));
}

/** A file with the map and without its obstacles may be one for something else. */
void warn_of_missing_obstacles(
    const mrpt::config::CConfigFileBase& ini, const std::string& name, const Options& o)
{
  if (o.map != "talus" || ini.sectionExists(kObstacles)) return;
  std::cerr << "talus-nav: warning: " << name << ": has no section [" << kObstacles
            << "]; obstacles are made with its defaults, see doc/obstacles.md\n";
}
}  // namespace

Settings load_settings(const Options& o)
{
  Settings s;
  s.name = o.config.empty() ? "the built-in configuration" : o.config;
  s.ini = !o.config.empty() ? text_of(o.config) : o.in_3d ? kReactive3D : kReactive2D;
  require_sound(s);
  try
  {
    mrpt::config::CConfigFileMemory ini;
    ini.setContent(s.ini);
    require_navigator(ini, o);
    for (const auto& w : load_parameters(ini, "CDualElevationMap", s.parameters))
      if (w.rfind("unknown key", 0) == 0)
        throw std::runtime_error(w);
      else
        std::cerr << "talus-nav: warning: " << s.name << ": " << w << "\n";
    if (o.map != "octomap" && s.parameters.resolution_m != kCostmapCell_m)
      throw std::runtime_error(mrpt::format(
          "resolution = %g m: must be %g m, as the costmap of the route has",
          s.parameters.resolution_m, kCostmapCell_m));
    warn_of_missing_obstacles(ini, s.name, o);
    s.obstacles.loadFromConfigFile(ini, kObstacles);
    check_planner_ini(ini, o.in_3d);
  }
  catch (const std::exception& e)
  {
    throw WrongConfiguration(s.name + ": " + io::reason_of(e));
  }
  return s;
}

std::unique_ptr<MapSource> make_source(const Options& o, const Settings& s, const RobotBody& body)
{
  if (o.map == "octomap") return make_octomap_source({});
  if (o.map == "onesurface") return make_onesurface_source(s.parameters, s.obstacles);
  return make_terrain_source(s.parameters, o.backend, o.threads, s.obstacles, body);
}

}  // namespace talus::nav
