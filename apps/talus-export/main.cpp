// talus-export: a map of terrain in, the same in formats of other programs out.
#include "../common/child_process.h"
#include "../common/command_line.h"
#include "../common/export/export_files.h"
#include "../common/output_folder.h"
#include "../common/run_app.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace app = talus::app;
namespace fs = std::filesystem;
using namespace talus::formats;

namespace
{
/** What the command line says. */
struct Options
{
  std::vector<std::string> inputs;
  app::ExportOptions exports;
  std::string output;  //!< a folder; empty: that of each map
  std::string title;  //!< of the page; empty: the folder and the name of the map
  bool quiet = false;
};

constexpr const char* kFooter =
    "Formats (of SITE.tif, beside it or in --output):\n"
    "  ros        SITE.yaml and SITE.pgm for map_server and Nav2: free, occupied, unknown\n"
    "  gridmap    SITE.gridmap.gz, MRPT's COccupancyGridMap2D\n"
    "  octomap    SITE.bt: ground and what stands on it occupied, the clearance above ground free\n"
    "  ply        SITE.ply: the ground as a coloured mesh, what stands as points\n"
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
         "--blocked-at", o.exports.blocked_at, "Cells of this traversability or less are occupied")
      ->check(app::between(0.0, 1.0))
      ->capture_default_str()
      ->type_name("T");
  app.add_option("--clearance", o.exports.clearance_m, "octomap: free height above bare ground [m]")
      ->check(app::between(0.0, 100.0))
      ->capture_default_str()
      ->type_name("M");
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

/** Refuses what no single option tells. */
void check(const Options& o)
{
  const bool has_page = std::find(o.exports.formats.begin(), o.exports.formats.end(), "html") !=
                        o.exports.formats.end();
  if (!o.exports.changes.empty() && !has_page)
    throw CLI::ValidationError("--changes is shown by html only: add it to --to");
  if (!o.exports.changes.empty() && o.inputs.size() > 1)
    throw CLI::ValidationError("--changes belongs to one map; give one");
}

void add_options(CLI::App& app, Options& options)
{
  app.description("Writes a map of terrain in the formats of other programs, or as a page.");
  add_files(app, options);
  add_settings(app, options);
  app.footer(kFooter);
  app.final_callback([&options] { check(options); });
}

constexpr const char* kLessMemory =
    "The map is read as a whole: cut out a part of it with gdal_translate, or take a machine with "
    "more memory";
/** "monday/site" for "logs/monday/site.tif". */
std::string title_of(const fs::path& file)
{
  return (fs::absolute(file).parent_path().filename() / file.stem()).string();
}

void export_all(const Options& o)
{
  for (const std::string& file : o.inputs)
  {
    const std::string folder = o.output.empty() ? fs::path(file).parent_path().string() : o.output;
    for (const std::string& path :
         app::export_files(file, folder, o.title.empty() ? title_of(file) : o.title, o.exports))
      if (!o.quiet) std::cout << "  wrote   " << path << "\n";
  }
}

/** Makes --output where it is missing. */
int run(const Options& o)
{
  std::unique_ptr<app::OutputFolder> folder;
  std::error_code none;
  if (!o.output.empty() && !fs::is_directory(o.output, none))
    folder = std::make_unique<app::OutputFolder>(o.output);
  const auto work = [&o]
  {
    export_all(o);
    return 0;
  };
  return app::run_command_in_child(o.inputs.front(), kLessMemory, work, app::print_error);
}
}  // namespace

int main(int argc, char** argv) { return app::run_app("talus-export", argc, argv, run); }
