#include "settings.h"

#include "builtin_configs.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <talus/mrpt/parameters_ini.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>

namespace talus::nav
{
namespace
{
constexpr const char* kObstacles = "talus_obstacles";

std::string text_of(const std::string& path)
{
  if (std::filesystem::is_directory(path))
    throw std::runtime_error(path + ": is a directory; give an INI file to --planner-config");
  std::ifstream file(path);
  if (!file)
    throw std::runtime_error(path + ": cannot be read; check the path given to --planner-config");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

void require_navigator(
    const mrpt::config::CConfigFileBase& ini, const std::string& name, const Options& o)
{
  const std::string section = o.in_3d ? "CReactiveNavigationSystem3D" : "CReactiveNavigationSystem";
  if (ini.sectionExists(section)) return;
  throw std::runtime_error(
      name + ": has no section [" + section + "]; --planner " + (o.in_3d ? "3d" : "2d") +
      " needs one such as in datasets/configs/reactive" + (o.in_3d ? "3d" : "2d") + "_config.ini");
}

/** Without the section the policies are other ones than in the shipped files, and the robot may
 * stand where those let it go. */
void warn_of_missing_obstacles(
    const mrpt::config::CConfigFileBase& ini, const std::string& name, const Options& o)
{
  if (o.octomap || ini.sectionExists(kObstacles)) return;
  std::cerr << "talus-nav: warning: " << name << ": has no section [" << kObstacles
            << "]; obstacles are made with its defaults (unknown, risky and inferred = near), see "
               "doc/navigation.md\n";
}
}  // namespace

Settings load_settings(const Options& o)
{
  Settings s;
  const std::string name = o.config.empty() ? "the built-in configuration" : o.config;
  s.ini = !o.config.empty() ? text_of(o.config) : o.in_3d ? kReactive3D : kReactive2D;
  mrpt::config::CConfigFileMemory ini;
  ini.setContent(s.ini);
  require_navigator(ini, name, o);
  try
  {
    for (const auto& w : load_parameters(ini, "CDualElevationMap", s.parameters))
      std::cerr << "talus-nav: warning: " << name << ": " << w << "\n";
    warn_of_missing_obstacles(ini, name, o);
    s.obstacles.loadFromConfigFile(ini, kObstacles);
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(name + ": " + e.what());
  }
  return s;
}

std::unique_ptr<MapSource> make_source(const Options& o, const Settings& s)
{
  if (o.octomap) return make_octomap_source({});
  return make_terrain_source(s.parameters, o.backend, o.threads, s.obstacles);
}

}  // namespace talus::nav
