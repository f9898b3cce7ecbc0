#include <cstdio>
#include <filesystem>
#include <iostream>
#include <utility>

#include "../../common/child_process.h"
#include "../../common/crash_context.h"
#include "../../common/log_name.h"
#include "../../common/output_folder.h"
#include "../../common/printable.h"
#include "../../common/progress_bar.h"
#include "options.h"

namespace fs = std::filesystem;

namespace
{
using namespace talus::sim;
using namespace talus::app;

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
  truth_options.movers = !o.without_movers;
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

void print_error(const std::string& text) { std::cerr << "talus-sim: " << text << "\n"; }

/** The exit code. */
int run(const Options& o)
{
  forward_signals();  // before any folder is made: a signal must not leave it behind
  OutputFolder output(o.output);
  const auto work = [&]
  {
    simulate(o, output.staging());
    return 0;
  };
  const auto tell = [&](const std::string& text) { print_error(output.told(text)); };
  if (const int code = run_command_in_child(o.world, kSimplerWorld, work, tell)) return code;
  const std::string log = name_of_world(o.world) + ".rawlog";
  output.commit(log);
  if (!o.quiet) std::cout << "  wrote   " << (fs::path(o.output) / log).string() << "\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv)
{
  const PrintableOutput printable;
  Options options;
  if (const auto exit_code = parse_options(argc, argv, options)) return *exit_code;
  return code_of([&] { return run(options); }, print_error, options.world, kSimplerWorld);
}
