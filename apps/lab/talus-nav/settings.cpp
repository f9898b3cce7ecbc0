#include "options.h"

#include "../../common/run_app.h"
#include "builtin_configs.h"
#include "planner_ini.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/format.h>
#include <talus/input_file.h>
#include <talus/io/mrpt_error.h>
#include <talus/mrpt/parameters_ini.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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
  app::print_error(
      "warning: " + name + ": has no section [" + kObstacles +
      "]; obstacles are made with its defaults, see doc/obstacles.md");
}

constexpr double kMargin_m = 1.5;
constexpr double kMax_m2 = 25000;  // 10 million cells, with the pictures 2 GB

struct Area
{
  double min_x_m, max_x_m, min_y_m, max_y_m;
};

/** Start, goal and all that stands in the world, with a margin. */
Area area_of(const sim::World& world, const Point2& start, const Point2& goal)
{
  Area a{
      std::min(start.x_m, goal.x_m), std::max(start.x_m, goal.x_m), std::min(start.y_m, goal.y_m),
      std::max(start.y_m, goal.y_m)};
  for (const auto& shape : world.objects.shapes())
  {
    const auto b = sim::bounds(shape);
    a.min_x_m = std::min(a.min_x_m, b.min_m.x);
    a.max_x_m = std::max(a.max_x_m, b.max_m.x);
    a.min_y_m = std::min(a.min_y_m, b.min_m.y);
    a.max_y_m = std::max(a.max_y_m, b.max_m.y);
  }
  return {
      a.min_x_m - kMargin_m, a.max_x_m + kMargin_m, a.min_y_m - kMargin_m, a.max_y_m + kMargin_m};
}

void require_manageable(const Area& a)
{
  const double size_m2 = (a.max_x_m - a.min_x_m) * (a.max_y_m - a.min_y_m);
  const double farthest_m = std::max({-a.min_x_m, a.max_x_m, -a.min_y_m, a.max_y_m});
  if (farthest_m <= kFarthest_m + kMargin_m && size_m2 <= kMax_m2) return;
  throw std::invalid_argument(mrpt::format(
      "start, goal and objects reach from (%.1f, %.1f) to (%.1f, %.1f) m; the limit is %.0f m from "
      "the origin and %.0f m2: choose a nearer --goal, or move what is far away in the world",
      a.min_x_m, a.min_y_m, a.max_x_m, a.max_y_m, kFarthest_m, kMax_m2));
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
        app::print_error("warning: " + s.name + ": " + w);
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
  if (o.map == "octomap") return make_octomap_source();
  if (o.map == "onesurface") return make_onesurface_source(s.parameters, s.obstacles);
  return make_terrain_source(s.parameters, o.backend, o.threads, s.obstacles, body);
}

Costmap start_costmap(const sim::World& world, const Point2& start, const Point2& goal)
{
  const Area area = area_of(world, start, goal);
  require_manageable(area);
  const auto up = [](double v) { return std::ceil(v / kCostmapCell_m) * kCostmapCell_m; };
  Costmap out{kCostmapCell_m, 0, 0, 0, 0, {}};
  out.cover(area.min_x_m, up(area.max_x_m), area.min_y_m, up(area.max_y_m));
  return out;
}

}  // namespace talus::nav
