#include "../../common/command_line.h"
#include "../../common/crash_context.h"
#include "../../common/log_name.h"
#include "../../common/output_folder.h"
#include "../../common/progress_bar.h"
#include "../../common/run_app.h"
#include "output.h"

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>

namespace fs = std::filesystem;

namespace
{
using namespace talus::sim;
using namespace talus::app;

/** What the command line says. */
struct Options
{
  std::string world, output;
  DriveOptions drive;
  Claims claims;
  double resolution_m = 0.05;
  bool quiet = false;
};

std::string footer()
{
  std::string text = "Scanners:\n";
  for (const Scanner& s : scanners())
    text += "  " + s.name + std::string(14 - s.name.size(), ' ') + s.description + "\n";
  return text +
         "\nExamples:\n"
         "  talus-sim datasets/worlds/demo.yaml --output out\n"
         "      out/demo.rawlog, out/demo.tum and out/truth.tif; then: talus-map out/demo.rawlog\n"
         "  talus-sim demo.yaml --output out --scanner OS1-64 --seed 3 --noise 0.02\n"
         "  talus-sim demo.yaml --output out --pose-noise 0.02 --z-drift 0.01\n"
         "      also out/demo_noisy.tum; then: talus-map out/demo.rawlog --trajectory "
         "out/demo_noisy.tum\n"
         "  talus-sim demo.yaml --output out --mounting-error 0,0,0.05,0,-3,2 --clock-error 0.05\n"
         "      a log for talus-calibrate to put right\n"
         "\nExit codes: 0 done, 1 failed, 2 wrong usage, 128 + N stopped by signal N.";
}

void add_world(CLI::App& app, Options& o)
{
  app.add_option("WORLD", o.world, "World file (.yaml); datasets/README.md describes the format")
      ->required();
  add_optional(app, "--scanner", o.drive.scanner, "Scanner instead of the world's, see below")
      ->type_name("NAME");
  add_checked(
      app, "--seed", o.drive.seed, "Seed of the noise instead of the world's", "N",
      whole_of_64_bits());
  add_checked(
      app, "--noise", o.drive.noise_m, "Standard deviation of a range [m]", "M", between(0, 10));
  add_checked(
      app, "--noise-per-m", o.drive.noise_per_m, "Its growth with the range [m/m]", "M/M",
      between(0, 1));
  add_checked(
      app, "--frames", o.drive.frames, "Write at most so many frames", "N", CLI::Range(1, 100000));
  add_checked(
      app, "--every", o.drive.every, "Of each sensor's sweeps, only the first of N", "N",
      CLI::Range(1, 100000));
  add_checked(
      app, "--cut-frames", o.drive.cut_frames,
      "Write a sweep as N frames, each with its own stamp and pose", "N", CLI::Range(1, 100));
}

void add_errors(CLI::App& app, Options& o)
{
  add_checked(
      app, "--pose-noise", o.drive.pose_noise_m,
      "Also write WORLD_noisy.tum: standard deviation in x, y, z [m]", "M", between(0, 10));
  add_checked(
      app, "--angle-noise", o.drive.angle_noise_rad, "The same in roll, pitch, yaw [rad]", "RAD",
      between(0, 1));
  add_checked(
      app, "--z-drift", o.drive.z_drift, "The same: climb of the noisy pose, metres a metre driven",
      "M/M", between(-1, 1));
  add_mounting(
      app, "--mounting-error", o.claims.mounting_error, "The log states a mounting that is off");
  add_checked(
      app, "--clock-error", o.claims.clock_error_s,
      "The stamps of the log are late by this against the trajectory [s]", "S", between(-10, 10));
}

void add_outputs(CLI::App& app, Options& o)
{
  app.add_option("--output", o.output, "Folder of the files; made if it does not exist")
      ->required()
      ->type_name("DIR");
  add_checked(
      app, "--resolution", o.resolution_m, "Side of a cell of truth.tif [m]", "M",
      between(0.001, 100))
      ->capture_default_str();
  app.add_flag("--quiet", o.quiet, "Print errors only");
}

void add_options(CLI::App& app, Options& options)
{
  app.description(
      "Drives a robot with a LiDAR through a world; writes its log, its way and the truth.");
  add_world(app, options);
  add_errors(app, options);
  add_outputs(app, options);
  app.footer(footer());
}

constexpr double kTruthMargin_m = 6.0;
constexpr const char* kSimplerWorld = "Try one with fewer things and a shorter way in it";

TruthWindow window_of(const Options& o, const Drive& drive)
{
  try
  {
    return window_around(drive.path().bounds(), kTruthMargin_m, o.resolution_m);
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(o.world + ": " + e.what());
  }
}

void write_files(
    const Options& o, const std::string& folder, const World& world, const Drive& drive, Truth last)
{
  const auto path = [&](const std::string& name)
  {
    require_apart(o.output, {name}, {o.world});
    return (fs::path(folder) / name).string();
  };
  write_truth(path("truth.tif"), std::move(last), world, drive.time_s(drive.frames() - 1));
  const std::string name = name_of_world(o.world);
  write_tum(path(name + ".tum"), drive, false);
  if (drive.has_pose_errors()) write_tum(path(name + "_noisy.tum"), drive, true);
  ProgressBar bar("talus-sim", !o.quiet);
  write_rawlog(
      path(name + ".rawlog"), world, drive, o.claims,
      [&](int done)
      { bar.show(static_cast<double>(done) / drive.frames(), "frame " + std::to_string(done)); });
}

std::string names_of_scanners(const World& world, const Drive& drive)
{
  std::string names;
  for (std::size_t s = 0; s < world.sensors.size(); ++s)
    names += (s == 0 ? "" : " and ") + drive.scanner(s).name;
  return names;
}

void simulate(const Options& o, const std::string& folder)
{
  const World world = guarded(o.world, kSimplerWorld, [&] { return load_world(o.world); });
  const Drive drive(world, o.drive);
  const double end_s = drive.time_s(drive.frames() - 1);
  TruthOptions truth_options;
  if (!world.decks.empty()) truth_options.level_m = drive.T_map_base(drive.frames() - 1).z();
  Truth last = truth(world, window_of(o, drive), end_s, truth_options);
  write_files(o, folder, world, drive, std::move(last));
  if (!o.quiet)
  {
    char way[40];
    std::snprintf(way, sizeof way, "%.1f m", drive.path().distance_m(end_s));
    std::cout << world.name << ": " << drive.frames() << " frames of "
              << names_of_scanners(world, drive) << " over " << way << "\n";
  }
}

/** The exit code. */
int run(const Options& o)
{
  const std::string log = name_of_world(o.world) + ".rawlog";
  const int code = make_results(
      o.output, log, o.world, kSimplerWorld,
      [&](const std::string& staging) { simulate(o, staging); });
  if (code == 0 && !o.quiet)
    std::cout << "  wrote   " << (fs::path(o.output) / log).string() << "\n";
  return code;
}

}  // namespace

int main(int argc, char** argv) { return run_app("talus-sim", argc, argv, run); }
