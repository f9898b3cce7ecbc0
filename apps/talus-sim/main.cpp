#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <utility>

#include "../common/interrupt.h"
#include "../common/option_checks.h"
#include "../common/output_folder.h"
#include "output.h"

namespace fs = std::filesystem;

namespace
{
using namespace talus::sim;
using namespace talus::app;

constexpr double kTruthMargin_m = 6.0;

struct Options
{
  std::string world, output = ".";
  DriveOptions drive;
  Claims claims;
  double resolution_m = 0.05;
  bool without_movers = false, quiet = false;
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
         "  talus-sim demo.yaml --output out --mounting-error 0 0 0.05 2 -3 0 --clock-error 0.05\n"
         "      a log for talus-calibrate to put right\n"
         "\nExit codes: 0 done, 1 failed, 2 wrong usage, 128 + N stopped by signal N.";
}

/** Adds an option whose value stays empty when it is not given. */
template <typename T>
CLI::Option* add_optional(
    CLI::App& app, const std::string& name, std::optional<T>& value, const std::string& help)
{
  return app.add_option_function<T>(
      name, [&value](const T& v) { value = v; }, help);
}

void add_options(CLI::App& app, Options& o)
{
  app.add_option("WORLD", o.world, "World file (.yaml); datasets/README.md describes the format")
      ->required();
  app.add_option("--output", o.output, "Folder of the files; made if it does not exist")
      ->required()
      ->type_name("DIR");
  add_optional(app, "--scanner", o.drive.scanner, "Scanner instead of the world's, see below")
      ->type_name("NAME");
  add_optional(app, "--seed", o.drive.seed, "Seed of the noise instead of the world's")
      ->check(whole_of_64_bits())
      ->type_name("N");
  add_optional(app, "--noise", o.drive.noise_m, "Standard deviation of a range [m]")
      ->check(between(0.0, 10.0))
      ->type_name("M");
  add_optional(app, "--noise-per-m", o.drive.noise_per_m, "Its growth with the range [m/m]")
      ->check(between(0.0, 1.0))
      ->type_name("M/M");
  add_optional(app, "--frames", o.drive.frames, "Write at most so many frames")
      ->check(CLI::Range(1, 100000))
      ->type_name("N");
  app.add_option(
         "--pose-noise", o.drive.pose_noise_m,
         "Also write WORLD_noisy.tum: standard deviation in x, y, z [m]")
      ->check(between(0.0, 10.0))
      ->type_name("M");
  app.add_option("--angle-noise", o.drive.angle_noise_rad, "The same in roll, pitch, yaw [rad]")
      ->check(between(0.0, 1.0))
      ->type_name("RAD");
  app.add_option(
         "--z-drift", o.drive.z_drift, "The same: climb of the noisy pose, metres a metre driven")
      ->check(between(-1.0, 1.0))
      ->type_name("M/M");
  check_mounting(app.add_option(
                     "--mounting-error", o.claims.mounting_error,
                     "The log states a mounting that is off by x y z roll pitch yaw [m, degrees]"))
      ->type_name("...");
  app.add_option(
         "--clock-error", o.claims.clock_error_s,
         "The stamps of the log are late by this against the trajectory [s]")
      ->check(between(-10.0, 10.0))
      ->type_name("S");
  app.add_option("--resolution", o.resolution_m, "Side of a cell of truth.tif [m]")
      ->check(between(0.001, 100.0))
      ->capture_default_str()
      ->type_name("M");
  app.add_flag("--no-movers", o.without_movers, "Leave what moves out of truth.tif");
  app.add_flag("--quiet", o.quiet, "Print errors only");
  app.set_version_flag("--version", std::string("talus-sim ") + TALUS_VERSION);
  app.footer(footer());
}

bool has_bar(const Options& o) { return !o.quiet && isatty(STDERR_FILENO); }

void show_progress(int done, int total)
{
  const int width = 40, filled = width * done / total;
  std::fprintf(
      stderr, "\r[%s%s] %d/%d frames%s", std::string(filled, '#').c_str(),
      std::string(width - filled, '.').c_str(), done, total, done == total ? "\n" : "");
}

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

std::string stem_of(const Options& o) { return fs::path(o.world).stem().string(); }

void write_files(
    const Options& o, const std::string& folder, const World& world, const Drive& drive, Truth last,
    const Interrupt& interrupt)
{
  const auto path = [&](const std::string& name)
  {
    require_apart((fs::path(o.output) / name).string(), {o.world});
    return (fs::path(folder) / name).string();
  };
  write_truth(path("truth.tif"), std::move(last), world, drive.time_s(drive.frames() - 1));
  write_tum(path(stem_of(o) + ".tum"), drive, false);
  if (drive.has_pose_errors()) write_tum(path(stem_of(o) + "_noisy.tum"), drive, true);
  write_rawlog(
      path(stem_of(o) + ".rawlog"), world, drive, o.claims,
      [&](int done)
      {
        if (has_bar(o)) show_progress(done, drive.frames());
        interrupt.check();
      });
}

/** All files appear together, or none. */
void simulate(const Options& o)
{
  const World world = load_world(o.world);
  const Drive drive(world, o.drive);
  const TruthWindow window = window_of(o, drive);
  require_writable(o.output);
  const double end_s = drive.time_s(drive.frames() - 1);
  TruthOptions truth_options;
  truth_options.movers = !o.without_movers;
  Truth last = truth(world, window, end_s, truth_options);
  const Interrupt interrupt;
  OutputFolder folder(o.output);
  try
  {
    write_files(o, folder.staging(), world, drive, std::move(last), interrupt);
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(folder.told(e.what()));
  }
  interrupt.check();
  folder.commit();
  if (o.quiet) return;
  std::printf(
      "%s: %d frames of %s over %.1f m -> %s\n", world.name.c_str(), drive.frames(),
      drive.scanner().name.c_str(), drive.path().distance_m(end_s),
      (fs::path(o.output) / (stem_of(o) + ".rawlog")).c_str());
}

}  // namespace

int main(int argc, char** argv)
{
  CLI::App app{
      "Drives a robot with a LiDAR through a world; writes its log, its way and the truth.",
      "talus-sim"};
  Options options;
  add_options(app, options);
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::ParseError& e)
  {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try
  {
    simulate(options);
  }
  catch (const Interrupted& e)
  {
    if (has_bar(options)) std::cerr << "\n";
    std::cerr << "talus-sim: stopped; nothing was written\n";
    return 128 + e.signal;
  }
  catch (const std::exception& e)
  {
    std::cerr << "talus-sim: " << e.what() << "\n";
    return 1;
  }
  return 0;
}
