#include "options.h"

#include "../common/command_line.h"
#include "../common/version.h"

#include <filesystem>
#include <iostream>

namespace talus::import
{
namespace
{
constexpr const char* kFooter =
    "SOURCE is a folder of KITTI's (velodyne/*.bin with times.txt, calib.txt and poses), a folder "
    "of\n"
    ".bin, .pcd or .ply files in the order of their names, one such file, or a ROS 2 bag. Each "
    "folder\n"
    "is one sensor, whose label is its name; several are merged in the order of time. LOG.tum gets "
    "the\n"
    "poses. doc/import.md says what is kept, and in which frames.\n"
    "\nExamples:\n"
    "  talus-import sequences/00 --output 00.rawlog\n"
    "      KITTI's odometry data; then: talus-map 00.rawlog --config datasets/configs/car.ini\n"
    "  talus-import sequences/00 --poses slam/00.txt --output 00.rawlog\n"
    "  talus-import lidar/ --poses poses.tum --mount lidar=0,0,0.6,0,0,0 --output drive.rawlog\n"
    "      .pcd or .ply files of a scanner 0.6 m above the ground\n"
    "  talus-import front/ rear/ --poses poses.tum --mount front=0.3,0,0.6,0,0,0 \\\n"
    "      --mount rear=-0.3,0,0.6,180,0,0 --output drive.rawlog\n"
    "  talus-import bag/ --topic /points --output drive.rawlog\n"
    "  talus-import lidar/ --poses kiss_poses.txt --poses-of sensor --mount lidar=0,0,0.6,0,0,0 "
    "\\\n"
    "      --output drive.rawlog\n"
    "      poses of KISS-ICP, FAST-LIO or MOLA are those of the sensor\n"
    "  talus-import registered/ --poses poses.tum --clouds-in map --output drive.rawlog\n"
    "  talus-import nuscenes/ --fields x,y,z,intensity,ring --output drive.rawlog\n"
    "\nExit codes: 0 done, 1 an input or the output failed, 2 wrong usage, 128 + N stopped by "
    "signal N.";

void add_options(CLI::App& app, Options& o)
{
  app.add_option("SOURCE", o.sources, "Folder of scans, file of one scan, or ROS 2 bag")
      ->required()
      ->check(app::not_empty());
  app.add_option("--output", o.output, "The log; its poses go into LOG.tum beside it")
      ->required()
      ->check(app::not_empty())
      ->type_name("LOG.rawlog");
  add_import_options(app, o.import);
  app.add_flag("--quiet", o.quiet, "Print errors only");
}

/** What no single option tells; empty: all is well. */
std::string mistake(const Options& o)
{
  const std::filesystem::path output(o.output);
  if (output.extension() != ".rawlog" || output.stem().empty())
    return "--output " + o.output + ": name a file that ends in .rawlog";
  return "";
}
}  // namespace

std::optional<int> parse_options(int argc, char** argv, Options& options)
{
  CLI::App app{"Makes a log for talus-map of scans of other programs.", "talus-import"};
  add_options(app, options);
  app.set_version_flag("--version", app::version_line("talus-import"));
  app.footer(kFooter);
  if (const auto code = app::parse_command_line(app, argc, argv)) return code;
  const std::string wrong = mistake(options);
  if (wrong.empty()) return std::nullopt;
  std::cerr << "talus-import: " << wrong << "\nRun 'talus-import --help' for usage.\n";
  return 2;
}

}  // namespace talus::import
