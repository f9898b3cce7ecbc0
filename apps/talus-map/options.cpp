#include "options.h"

#include "../common/command_line.h"
#include "../common/settings.h"
#include "../common/export/export_files.h"
#include "job.h"
#include "kept_site.h"

#include <talus/mrpt/parameters_ini.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace talus::app
{
namespace
{
constexpr const char* kFooter =
    "Writes into DIR:\n"
    "  site.png, site.tif   all that the drive saw: a picture, and a Cloud Optimized GeoTIFF; "
    "other\n"
    "                       floors: site_floor_1.tif ..., parts far away: site_island_1.tif ...\n"
    "  map.png, map.tif     the window after the last frame: where the robot can drive and the\n"
    "                       other layers, and a GeoTIFF with a band for each layer\n"
    "  site.qml, map.qml    styles of QGIS: these GeoTIFFs open in the colours of talus\n"
    "  timing.csv, summary.json   a row for each frame; all figures and parameters\n"
    "All files appear together when a log is done, summary.json last. A log that fails writes "
    "nothing.\n"
    "\n"
    "Poses come from the first of: --static, --trajectory, NAME.tum beside NAME.rawlog, the log.\n"
    "Scans of other programs become a log first, which is removed at the end. Their poses are "
    "found\n"
    "as by talus-import (KITTI's, TF ...). Several folders of one robot need talus-import.\n"
    "\n"
    "Examples:\n"
    "  talus-map --static scan.rawlog\n"
    "      a single scan, or a robot that stood still: scan_map/map.png\n"
    "  talus-map dataset/sequences/00 --config datasets/configs/car.ini\n"
    "      KITTI's odometry data: 00_map/site.png; --keep-log keeps 00_map/00.rawlog, too\n"
    "  talus-map scans/ --poses poses.tum --mount scans=0,0,0.6,0,0,0\n"
    "      a folder of .pcd, .ply or .bin files of a scanner 0.6 m above the ground\n"
    "  talus-map bag/ --topic /points --output out\n"
    "      one PointCloud2 topic of a ROS 2 bag, with the poses of its TF\n"
    "  talus-map drive.rawlog --trajectory drive.tum --output out\n"
    "  talus-map logs/*.rawlog --output out\n"
    "      one folder a log: out/NAME/; logs/NAME.tum is found by itself\n"
    "  talus-map logs/*.rawlog --jobs 4 --memory 2000\n"
    "      four logs at a time, each with 500 MB for its site map\n"
    "  talus-map car.rawlog -s window_m=24 -s resolution_m=0.1 -s clearance_m=2\n"
    "      a car, its sensor 1.9 m above the ground; --parameters lists everything that can be "
    "set\n"
    "  talus-map drive.rawlog --config robot.ini --every 10\n"
    "      also map and picture of each tenth frame: drive_map/frames/\n"
    "  talus-map drive.rawlog --suggest > robot.ini\n"
    "      a configuration to begin with: window, heights, body, noise, each with its reason\n"
    "  talus-map tuesday.rawlog --resume monday_map/site.tif\n"
    "      goes on with the site map of an earlier drive in the same map frame\n"
    "  talus-map drive.rawlog --origin 36.8383,-2.4045,52,30\n"
    "      where the map is on Earth: site.tif has a CRS; without it the log's own GPS counts\n"
    "  talus-map dataset/sequences/00 --config datasets/configs/car.ini --labels labels\n"
    "      what each point is: labels/000000.label and so on, their numbers in labels.yaml\n"
    "  talus-map drive.rawlog --rawlog-out terrain.rawlog\n"
    "      for rawlog-edit -p libtalus-mrpt.so --info -i terrain.rawlog\n"
    "\n"
    "Hints: a line 'hint: ...' names a setting that looks wrong (height band, window, mounting, "
    "poses,\n"
    "the body of the robot ...) and its remedy (doc/hints.md); --strict makes hints errors.\n"
    "\n"
    "Exit codes: 0 done, 1 a log failed, 2 wrong usage, 128 + N stopped by signal N.";

constexpr const char* kImportGroup =
    "Scans of other programs (folders, files, ROS 2 bags), as talus-import reads them";

void print_parameters()
{
  const Parameters defaults;
  std::printf("Parameters for -s NAME=VALUE and for --config, with their defaults:\n");
  for (const auto& info : parameter_table())
  {
    const std::string value =
        parameter_text(defaults, info) + " " + (info.is_text() ? "" : info.unit);
    std::printf("  %-22s %-12s %s\n", info.name, value.c_str(), info.description);
  }
}

void add_inputs(CLI::App& app, Options& o)
{
  app.add_option(
         "LOG", o.logs,
         "Rawlogs (plain, gz or zstd) or folders of them; simplemaps; folders or files of scans "
         "(KITTI, .bin, "
         ".pcd, .ply) and ROS 2 bags, each of which becomes a log first; several are a batch")
      ->required()
      ->check(not_empty())
      ->type_name("");
  auto* trajectory = add_text(
      app, "--trajectory", o.trajectory, "FILE",
      "Poses of the robot: TUM text (t x y z qx qy qz qw, base in map) or .simplemap");
  auto* is_static =
      app.add_flag("--static", o.robot_is_static, "The robot does not move; needs no poses")
          ->excludes(trajectory);
  app.add_flag(
         "--level", o.is_levelled,
         "Turn the map until the robot stands upright on average over its path: for poses of a "
         "SLAM program whose map is tilted as the sensor was")
      ->excludes(is_static);
  add_number(
      app, "--max-gap", o.max_gap_s, 0.0, 1e6, "S",
      "Scans between poses farther apart than this are skipped [s]");
  add_text(
      app, "--sensor", o.sensor, "LABEL", "Only the sensor of this label (default: every sensor)");
}

/** What talus-import has, under a heading of its own. */
void add_import(CLI::App& app, Options& o)
{
  const std::vector<CLI::Option*> before = app.get_options();
  import::add_import_options(app, o.import);
  app.add_flag(
      "--keep-log", o.keep_log, "Keep the log that is made, and its poses, beside the map");
  for (CLI::Option* option : app.get_options())
    if (std::find(before.begin(), before.end(), option) == before.end())
      option->group(kImportGroup);
  app.get_option("--poses")->excludes("--trajectory")->excludes("--static");
}

void add_processing(CLI::App& app, Options& o)
{
  add_map_settings(app, o.config, o.overrides, o.backend);
  app.add_option_function<int>(
         "--threads", [&o](int n) { o.threads = n; },
         "Threads of the CPU backend for each log, 0: all cores, which several logs share "
         "(default: "
         "0)")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  app.add_option_function<int>(
         "--device", [&o](int n) { o.device = n; },
         "Number of the GPU of the CUDA backend, from 0 (default: a batch is dealt out over all)")
      ->check(CLI::Range(0, 1023))
      ->type_name("N");
  app.add_option(
         "--jobs", o.jobs,
         "Logs to map at once, which share --memory (default: the cores over --threads, 64 MB "
         "each, two a GPU)")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
}

void add_site(CLI::App& app, Options& o)
{
  auto* none = app.add_flag(
      "--no-site", [&o](std::int64_t) { o.has_site = false; },
      "Keep and write no site map: the window after the last frame is all");
  constexpr double kMin_mb = 4, kMax_mb = 1e7;
  app.add_option(
         "--memory", o.memory_mb,
         "Memory of the site map [MB], of all logs that are mapped at once; what finds no room "
         "waits "
         "in the output folder")
      ->check(between(kMin_mb, kMax_mb))
      ->capture_default_str()
      ->excludes(none)
      ->type_name("MB");
  app.add_flag("--keep-new", o.keep_new, "Cells that come back into the window start empty")
      ->excludes(none);
  app.add_flag(
         "--keep-far", o.keep_far,
         "Write a floor as one file, however far its parts lie from each other: takes long "
         "(default: "
         "what is far has a file of its own)")
      ->excludes(none);
  app.add_flag(
         "--traffic", o.traffic,
         "Write traffic.tif, too: how often something that moved was in each cell, how many scans "
         "hit it")
      ->excludes(none);
  app.add_option(
         "--resume", o.resume,
         "Site map of an earlier run to go on with, and those of its other floors beside it (one "
         "log)")
      ->check(not_empty())
      ->excludes(none)
      ->type_name("SITE.tif");
  app.add_option_function<std::string>(
         "--origin",
         [&o](const std::string& text)
         {
           try
           {
             o.origin = origin_from_text(text);
           }
           catch (const std::invalid_argument& e)
           {
             throw CLI::ValidationError("--origin", e.what());
           }
         },
         "Where the origin of the map is on Earth (WGS 84) [degrees, m], and the heading of its x "
         "axis, counter-clockwise from east [degrees] (default: by the GPS of the log, if it has "
         "any)")
      ->excludes(none)
      ->type_name("LAT,LON[,ALT[,HEADING]]");
}

/** channels_from(), in which rgb:RULE stands for three. */
std::vector<Channel> channels_from_text(const std::string& text)
{
  const std::string rgb = "rgb:";
  std::string names;
  std::istringstream pieces(text);
  for (std::string piece; std::getline(pieces, piece, ',');)
  {
    const bool is_rgb = piece.rfind(rgb, 0) == 0;
    const std::string rule = is_rgb ? piece.substr(rgb.size()) : "";
    if (!names.empty()) names += ",";
    names += is_rgb ? "red:" + rule + ",green:" + rule + ",blue:" + rule : piece;
  }
  try
  {
    return channels_from(names);
  }
  catch (const std::invalid_argument& e)
  {
    throw CLI::ValidationError("--channels", e.what());
  }
}

void add_outputs(CLI::App& app, Options& o)
{
  add_formats(
      app, "--export", o.exports,
      "Write the site map as talus-export does, too: site.html and so on; without one the map of "
      "the window");
  add_text(
      app, "--output", o.output, "DIR",
      "Folder of the results; a batch makes one folder a log in it (default: NAME_map)");
  app.add_option("--every", o.every, "Also write map and picture of every Nth frame")
      ->check(CLI::Range(1, 1000000000))
      ->type_name("N");
  add_text(
      app, "--rawlog-out", o.rawlog_out, "FILE.rawlog",
      "Also write the log with a snapshot of the map after each scan, or each Nth with --every "
      "(of one log)");
  app.add_option_function<std::string>(
         "--channels", [&o](const std::string& text) { o.channels = channels_from_text(text); },
         "Also map values that points bring: intensity, red, green, blue (or rgb for the three), "
         "and "
         "fields of clouds; the rule is mean, latest, max or vote (of classes from 0 to 15)")
      ->type_name("NAME:RULE,...");
  app.add_flag(
      "--risk", o.risk,
      "Also write the layer risk: the probability that a cell is impassable, by its "
      "error estimates");
  auto* labels = add_text(
      app, "--labels", o.labels, "DIR",
      "Also write what each point of each scan is (ground, stands, hangs ...) into "
      "this folder, a file a scan as in SemanticKITTI; a batch makes one folder a "
      "log in it");
  app.add_option_function<std::string>(
         "--labels-as",
         [&o](const std::string& text)
         { o.labels_as = text == "rawlog" ? LabelsAs::Rawlog : LabelsAs::Kitti; },
         "kitti: .label files; rawlog: one log of clouds whose intensity is the label (default: "
         "kitti)")
      ->check(CLI::IsMember({"kitti", "rawlog"}))
      ->needs(labels)
      ->type_name("FORMAT");
  app.add_flag("--quiet", o.quiet, "Print warnings, hints and errors only");
  app.add_flag(
      "--strict", o.strict, "Hints are errors: exit code 1, and nothing is written of that log");
  app.add_flag(
         "--suggest", o.suggest,
         "Map nothing: print a configuration (--config) that suits the log, with reasons (of one "
         "log)")
      ->excludes(labels);
}
/** Switches that only an import heeds, of those that were given. */
std::vector<std::string> import_switches(const CLI::App& app)
{
  std::vector<std::string> given;
  for (const CLI::Option* option : app.get_options())
    if (option->get_group() == kImportGroup && option->count() > 0 &&
        option->get_name() != "--poses")
      given.push_back(option->get_name());
  return given;
}

/** What all options together mean. */
void finish(const CLI::App& app, Options& o)
{
  o.logs = logs_in(o.logs);
  o.import_switches = import_switches(app);
  if (o.trajectory.empty()) o.trajectory = o.import.source.poses;
  o.import.source.poses = o.trajectory;
  if (o.logs.size() < 2) return;
  const auto refuse = [](const std::string& option, const std::string& what_else)
  { throw CLI::ValidationError(option, "takes one log, not a batch" + what_else); };
  if (!o.rawlog_out.empty()) refuse("--rawlog-out", "");
  if (o.suggest) refuse("--suggest", "");
  if (!o.resume.empty())
    refuse("--resume", "; map one log after the other, each with the site map of the one before");
}
}  // namespace

void add_options(CLI::App& app, Options& options)
{
  app.description(
      "Maps the terrain around a robot from LiDAR scans: of MRPT rawlogs, folders and ROS 2 bags.");
  add_inputs(app, options);
  add_processing(app, options);
  add_outputs(app, options);
  add_site(app, options);
  add_import(app, options);
  app.add_flag_callback(
         "--parameters",
         []
         {
           print_parameters();
           throw CLI::Success();
         },
         "List all parameters with defaults and meaning")
      ->trigger_on_parse();  // before anything is missed
  app.footer(kFooter);
  app.final_callback([&app, &options] { finish(app, options); });
}

}  // namespace talus::app
