// talus-import: scans of other programs in, a log for talus-map out.
#include "../common/command_line.h"
#include "../common/import/import_log.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/progress_bar.h"
#include "../common/run_app.h"

#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace app = talus::app;
namespace fs = std::filesystem;
using namespace talus::import;
using talus::app::ProgressBar;

namespace
{
/** What the command line says. */
struct Options
{
  std::vector<std::string> sources;
  std::string output;  //!< ends in .rawlog
  ImportOptions import;
  bool quiet = false;
};

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

/** Refuses what no single option shows. */
void check(const Options& o)
{
  const std::filesystem::path output(o.output);
  if (output.extension() != ".rawlog" || output.stem().empty())
    throw CLI::ValidationError("--output " + o.output + ": name a file that ends in .rawlog");
}

void add_options(CLI::App& app, Options& o)
{
  app.description("Makes a log for talus-map of scans of other programs.");
  app.footer(kFooter);
  app.add_option("SOURCE", o.sources, "Folder of scans, file of one scan, or ROS 2 bag")
      ->required()
      ->check(app::not_empty());
  app.add_option("--output", o.output, "The log; its poses go into LOG.tum beside it")
      ->required()
      ->check(app::not_empty())
      ->type_name("LOG.rawlog");
  add_import_options(app, o.import);
  app.add_flag("--quiet", o.quiet, "Print errors only");
  app.final_callback([&o] { check(o); });
}

constexpr const char* kLessAtOnce = "Import fewer sources at once";

/** What lies beside a log counts as its poses. */
void require_no_old_poses(const std::string& tum)
{
  if (fs::exists(tum))
    throw std::runtime_error(
        tum +
        ": lies there already, but these scans have no poses, and talus-map would take those. "
        "Remove it, pass --poses, or give the log another name.");
}

void report(const Options& o, const ImportedLog& log)
{
  std::cout << o.output << ": " << contents_text(log) << "\n";
  std::cout << "  poses   " << poses_text(log)
            << (log.poses.count ? "" : ": talus-map needs --trajectory FILE, or --static") << "\n";
  for (const auto& remark : log.remarks) std::cout << "  note    " << remark << "\n";
  for (const auto& warning : log.warnings) std::cout << "  warning " << warning << "\n";
}

ImportedLog import_into(const Options& o, const fs::path& folder)
{
  const std::string log = (folder / fs::path(o.output).filename()).string();
  const std::string tum = (folder / fs::path(app::trajectory_beside(o.output)).filename()).string();
  ProgressBar bar("talus-import", !o.quiet);
  return import_log(
      o.sources, o.import, log, tum,
      [&](double done, const std::string& points) { bar.show(done, points); });
}

void import_all(const Options& o, const fs::path& folder)
{
  const ImportedLog log = import_into(o, folder);
  if (log.poses.count == 0) require_no_old_poses(app::trajectory_beside(o.output));
  if (!o.quiet) report(o, log);
}

void require_all_apart(const Options& o)
{
  auto inputs = o.sources;
  if (!o.import.source.poses.empty()) inputs.push_back(o.import.source.poses);
  app::require_apart("", {o.output, app::trajectory_beside(o.output)}, inputs);
}

/** The exit code. */
int run(const Options& o)
{
  require_all_apart(o);
  const fs::path output(o.output);
  const int code = app::make_results(
      output.has_parent_path() ? output.parent_path().string() : ".", output.filename().string(),
      o.sources.front(), kLessAtOnce, [&](const std::string& staging) { import_all(o, staging); });
  if (code != 0 || o.quiet) return code;
  const std::string tum = app::trajectory_beside(o.output);
  std::cout << "  wrote   " << o.output << (fs::exists(tum) ? " and " + tum : "") << "\n";
  return 0;
}
}  // namespace

int main(int argc, char** argv) { return app::run_app("talus-import", argc, argv, run); }
