#include "options.h"

#include "../common/command_line.h"
#include "../common/export/export_options.h"
#include "../common/version.h"

#include <algorithm>
#include <iostream>
#include <map>

namespace talus::formats
{
namespace
{
constexpr const char* kFooter =
    "Formats (of SITE.tif, beside it or in --output):\n"
    "  ros        SITE.yaml and SITE.pgm for map_server and Nav2: free, occupied, unknown\n"
    "  occupancy  SITE.gridmap.gz, MRPT's COccupancyGridMap2D\n"
    "  octomap    SITE.bt: ground and what stands on it occupied, the clearance above ground free\n"
    "  ply        SITE.ply: the ground as a coloured mesh, what stands as boxes\n"
    "  heightmap  SITE_height.png of 16 bit for Gazebo and game engines, and SITE_height.json\n"
    "  qgis       SITE.qml: QGIS opens SITE.tif in the colours of talus; keep them in one folder\n"
    "  html       SITE.html: one file for any browser, without a network\n"
    "\nExamples:\n"
    "  talus-export map/site.tif --to html\n"
    "  talus-export map/site.tif --to ros,octomap --output share\n"
    "  talus-export friday/site.tif --to html --changes changes/changes.tif\n"
    "      what talus-merge --changes found lies over the map, with a slider\n"
    "\nExit codes: 0 done, 1 an input or the output failed, 2 wrong usage, 128 + N stopped by "
    "signal N.";

void add_files(CLI::App& app, Options& o)
{
  app.add_option("MAP", o.inputs, "Maps: site.tif or map.tif of talus-map, a site of talus-merge")
      ->required()
      ->check(app::not_empty());
  app::add_formats(app, "--to", o.exports, "Formats, with commas between them: see below")
      ->required();
  app.add_option("--output", o.output, "Folder of the files (default: that of the map)")
      ->check(app::not_empty())
      ->type_name("DIR");
}

void add_settings(CLI::App& app, Options& o)
{
  static const std::map<std::string, RosMode> modes{
      {"trinary", RosMode::Trinary}, {"scale", RosMode::Scale}};
  app.add_option(
         "--ros-mode", o.exports.ros_mode, "scale: also how well a free cell drives, as a .png")
      ->transform(CLI::CheckedTransformer(modes))
      ->default_str("trinary")
      ->type_name("trinary|scale");
  app.add_option(
         "--blocked-at", o.exports.occupancy.blocked_at,
         "Cells of this traversability or less are occupied")
      ->check(app::between(0.0, 1.0))
      ->capture_default_str()
      ->type_name("T");
  app.add_option(
         "--close-islands", o.exports.occupancy.close_islands_m,
         "ros, occupancy: free islands smaller than this, the robot, are closed [m]; 0: none")
      ->check(app::between(0.0, 100.0))
      ->capture_default_str()
      ->type_name("M");
  app.add_option("--clearance", o.exports.clearance_m, "octomap: free height above bare ground [m]")
      ->check(app::between(0.0, 100.0))
      ->capture_default_str()
      ->type_name("M");
  app.add_option(
         "--origin", o.origin,
         "ply, octomap: is taken off all coordinates [m] (default: whole kilometres from 8 km on)")
      ->expected(3)
      ->delimiter(',')
      ->type_name("X,Y,Z");
  app.add_option(
         "--max-faces", o.exports.max_faces, "ply: cells are joined until the mesh has no more")
      ->check(CLI::Range(1000, 1'000'000'000))
      ->capture_default_str()
      ->type_name("N");
  app.add_option(
         "--max-mb", o.exports.max_mb, "html: cells are joined until the page is smaller [MB]")
      ->check(CLI::Range(1, 2000))
      ->capture_default_str()
      ->type_name("MB");
  app.add_option(
         "--changes", o.exports.changes, "html: changes.tif of talus-merge, to show over the map")
      ->check(app::not_empty())
      ->type_name("FILE");
  app.add_option(
         "--title", o.title, "html: title of the page (default: folder and name of the map)")
      ->check(app::not_empty())
      ->type_name("TEXT");
  app.add_flag("--quiet", o.quiet, "Print warnings and errors only");
}

/** What no single option tells; empty: all is well. */
std::string mistake(const Options& o)
{
  const bool has_page = std::find(o.exports.formats.begin(), o.exports.formats.end(), "html") !=
                        o.exports.formats.end();
  if (!o.exports.changes.empty() && !has_page)
    return "--changes is shown by html only: add it to --to";
  if (!o.exports.changes.empty() && o.inputs.size() > 1)
    return "--changes belongs to one map; give one";
  return "";
}
}  // namespace

std::optional<int> parse_options(int argc, char** argv, Options& options)
{
  CLI::App app{
      "Writes a map of terrain in the formats of other programs, or as a page.", "talus-export"};
  add_files(app, options);
  add_settings(app, options);
  app.set_version_flag("--version", app::version_line("talus-export"));
  app.footer(kFooter);
  if (const auto code = app::parse_command_line(app, argc, argv)) return code;
  if (const auto& at = options.origin; !at.empty()) options.exports.origin = {at[0], at[1], at[2]};
  const std::string wrong = mistake(options);
  if (wrong.empty()) return std::nullopt;
  std::cerr << "talus-export: " << wrong << "\nRun 'talus-export --help' for usage.\n";
  return 2;
}

}  // namespace talus::formats
