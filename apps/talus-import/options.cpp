#include "options.h"

#include "../common/command_line.h"
#include "../common/version.h"

#include <talus/number_text.h>

#include <array>
#include <cmath>
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
    "\nExit codes: 0 done, 1 an input or the output failed, 2 wrong usage, 128 + N stopped by "
    "signal N.";

/** "LABEL=x,y,z,yaw,pitch,roll", in metres and degrees. What is wrong, or "". */
std::string read_mounting(const std::string& text, SourceOptions& options)
{
  const auto sign = text.rfind('=');
  if (sign == std::string::npos || sign == 0)
    return "'" + text + "' is not LABEL=x,y,z,yaw,pitch,roll";
  std::array<double, 6> v{};
  std::size_t begin = sign + 1;
  for (std::size_t i = 0; i < v.size(); ++i)
  {
    const std::size_t end = i + 1 < v.size() ? text.find(',', begin) : text.size();
    if (end == std::string::npos) return "'" + text + "' has fewer than six numbers";
    const double limit = i < 3 ? 100 : 360;  // [m], [degrees]
    const auto value = number_from(std::string_view(text).substr(begin, end - begin));
    if (!value || !(std::abs(*value) <= limit))
      return "'" + text.substr(begin, end - begin) + "' in '" + text + "' is not a number in [-" +
             number_text(limit) + " - " + number_text(limit) + "]";
    v[i] = *value;
    begin = end + 1;
  }
  const auto radians = [](double degrees) { return degrees * M_PI / 180; };
  options.mountings[text.substr(0, sign)] =
      mrpt::poses::CPose3D(v[0], v[1], v[2], radians(v[3]), radians(v[4]), radians(v[5]));
  return "";
}

void add_options(CLI::App& app, Options& o)
{
  app.add_option("SOURCE", o.sources, "Folder of scans, file of one scan, or ROS 2 bag")
      ->required()
      ->check(app::not_empty());
  app.add_option("--output", o.output, "The log; its poses go into LOG.tum beside it")
      ->required()
      ->check(app::not_empty())
      ->type_name("LOG.rawlog");
  app.add_option(
         "--poses", o.source.poses,
         "Of the base: TUM text or an MRPT .simplemap; of KITTI's camera: 12 numbers a line")
      ->check(app::not_empty())
      ->type_name("FILE");
  app.add_option_function<std::vector<std::string>>(
         "--mount",
         [&o](const std::vector<std::string>& all)
         {
           for (const auto& text : all)
             if (const auto wrong = read_mounting(text, o.source); !wrong.empty())
               throw CLI::ValidationError("--mount", wrong);
         },
         "Where a sensor is on the base [m, degrees]; again for each")
      ->allow_extra_args(false)
      ->type_name("LABEL=x,y,z,yaw,pitch,roll");
  app.add_option("--rate", o.source.rate_hz, "Scans a second, where nothing says their times")
      ->check(app::between(0.001, 1e6))
      ->capture_default_str()
      ->type_name("HZ");
}

void add_options_of_bags(CLI::App& app, Options& o)
{
  app.add_option(
         "--topic", o.source.topics,
         "Of a bag: only this PointCloud2 topic, or poses of this topic; again for each")
      ->allow_extra_args(false)
      ->check(app::not_empty())
      ->type_name("NAME");
  app.add_option(
         "--base-frame", o.source.base_frame,
         "Of a bag: the base in TF (else base_link, base_footprint or the child of odometry)")
      ->type_name("NAME");
  app.add_option("--map-frame", o.source.map_frame, "Of a bag: the map in TF (else map, or odom)")
      ->type_name("NAME");
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
  add_options_of_bags(app, options);
  app.set_version_flag("--version", app::version_line("talus-import"));
  app.footer(kFooter);
  if (const auto code = app::parse_command_line(app, argc, argv)) return code;
  const std::string wrong = mistake(options);
  if (wrong.empty()) return std::nullopt;
  std::cerr << "talus-import: " << wrong << "\nRun 'talus-import --help' for usage.\n";
  return 2;
}

}  // namespace talus::import
