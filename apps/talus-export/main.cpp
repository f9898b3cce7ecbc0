// talus-export: a map of terrain in, the same in formats of other programs out.
#include "../common/child_process.h"
#include "../common/command_line.h"
#include "../common/crash_context.h"
#include "../common/export/export_files.h"
#include "../common/export/export_formats.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/run_app.h"

#include <talus/io/geotiff.h>
#include <talus/site/site_geotiff.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace app = talus::app;
namespace fs = std::filesystem;
using namespace talus::formats;
using app::OutputFolder;
using app::print_error;

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
    "  occupancy  SITE.gridmap.gz, MRPT's COccupancyGridMap2D\n"
    "  gridmap    SITE_gridmap.mcap, a bag with ANYbotics' grid_map_msgs/msg/GridMap\n"
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
  app::add_text(app, "--output", o.output, "DIR", "Folder of the files (default: that of the map)");
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
  app::add_number(
      app, "--blocked-at", o.exports.occupancy.blocked_at, 0.0, 1.0, "T",
      "Cells of this traversability or less are occupied");
  app::add_number(
      app, "--close-islands", o.exports.occupancy.close_islands_m, 0.0, 100.0, "M",
      "ros, occupancy: free islands smaller than this, the robot, are closed [m]; 0: none");
  app::add_number(
      app, "--clearance", o.exports.clearance_m, 0.0, 100.0, "M",
      "octomap: free height above bare ground [m]");
  app.add_option_function<std::vector<double>>(
         "--origin",
         [&o](const std::vector<double>& at) {
           o.exports.origin = {at[0], at[1], at[2]};
         },
         "occupancy, ply, octomap: is taken off all coordinates [m] (default: whole kilometres "
         "from 8 km on)")
      ->expected(3)
      ->delimiter(',')
      ->check(app::between(-1e9, 1e9))
      ->type_name("X,Y,Z");
  app::add_number(
      app, "--max-faces", o.exports.max_faces, 1000, 1'000'000'000, "N",
      "ply: cells are joined until the mesh has no more");
  app::add_number(
      app, "--max-mb", o.exports.max_mb, 1, 2000, "MB",
      "html: cells are joined until the page is smaller [MB]");
  app::add_text(
      app, "--changes", o.exports.changes, "FILE",
      "html: changes.tif of talus-merge, to show over the map");
  app::add_text(
      app, "--title", o.title, "TEXT",
      "html: title of the page (default: folder and name of the map)");
  app.add_flag("--quiet", o.quiet, "Print warnings and errors only");
}

/** Refuses what is wrong of several options together. */
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

std::string folder_for(const std::string& file, const Options& o)
{
  if (!o.output.empty()) return o.output;
  const fs::path beside = fs::path(file).parent_path();
  return beside.empty() ? "." : beside.string();
}

/** An input, and the files of its map. */
struct Input
{
  std::string file;
  std::vector<std::string> map;
};

/** Before the work: no file is written over an input or over another one. */
void require_files_apart(const std::vector<Input>& inputs, const Options& o)
{
  std::vector<std::string> read = o.inputs;
  read.push_back(o.exports.changes);
  std::map<fs::path, std::string> written_for;
  for (const Input& input : inputs)
  {
    const auto files = app::files_of_export(input.map, folder_for(input.file, o), o.exports);
    app::require_apart("", files, read);
    for (const std::string& written : files)
    {
      const auto [first, is_new] =
          written_for.emplace(fs::weakly_canonical(fs::absolute(written)), input.file);
      if (!is_new && !app::is_same_file(first->second, input.file))
        throw std::runtime_error(
            first->second + " and " + input.file + ": both would be written as " + written +
            "; export them one by one, each with an --output of its own");
    }
  }
}

/** By its name. */
using Folders = std::map<std::string, std::unique_ptr<OutputFolder>>;

/** The exit code: what fails costs no other file. */
int export_all(const Options& o, const Folders& folders)
{
  int code = 0;
  std::vector<Input> inputs;
  for (const std::string& file : o.inputs)
  {
    const auto look = [&]
    {
      const std::vector<std::string> map = app::files_of_map(file);
      if (talus::site::is_site(talus::io::GeotiffFile(file)))
        for (const std::string& part : map) talus::site::require_whole(part);
      inputs.push_back({file, map});
      return 0;
    };
    code = std::max(code, app::code_of(look, print_error, file, kLessMemory));
  }
  require_files_apart(inputs, o);
  for (const auto& [file, map] : inputs)
  {
    const OutputFolder& folder = *folders.at(folder_for(file, o));
    const app::Exported exported = app::export_files(
        map, folder.staging(), o.title.empty() ? app::name_of_map(file) : o.title, o.exports);
    for (const std::string& note : exported.notes) print_error(folder.shown("warning: " + note));
    for (const std::string& error : exported.errors) print_error(folder.shown(error));
    if (!exported.errors.empty()) code = 1;
  }
  return code;
}

/** Puts all files of a folder in their place: what lies beside a main file, such as the picture of
 * a .yaml, before it. */
void commit(const std::string& name, OutputFolder& folder, const Options& o)
{
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder.staging()))
    if (const auto file = entry.path().filename().string(); app::is_main_file(file))
      files.insert(file);
  if (files.empty()) return;
  folder.commit(files);
  if (o.quiet) return;
  for (const std::string& file : files)
    std::cout << "  wrote   " << (fs::path(name) / file).lexically_normal().string() << "\n";
}

int run(const Options& o)
{
  Folders folders;
  for (const std::string& file : o.inputs)
    if (auto& folder = folders[folder_for(file, o)]; !folder)
      folder = std::make_unique<OutputFolder>(folder_for(file, o));
  const auto work = [&] { return export_all(o, folders); };
  const int code = app::run_command_in_child(o.inputs.front(), kLessMemory, work, print_error);
  if (code <= 128)  // not stopped
    for (const auto& [name, folder] : folders) commit(name, *folder, o);
  return code;
}
}  // namespace

int main(int argc, char** argv) { return app::run_app("talus-export", argc, argv, run); }
