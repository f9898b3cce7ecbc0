#include <cstdio>
#include <filesystem>
#include <iostream>
#include <utility>

#include "../common/interrupt.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/printable.h"
#include "../common/progress_bar.h"
#include "../common/suspect.h"
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
    const Options& o, const std::string& folder, const World& world, const Drive& drive, Truth last,
    const Interrupt& interrupt)
{
  const auto path = [&](const std::string& name)
  {
    require_apart((fs::path(o.output) / name).string(), {o.world});
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
      {
        bar.show(static_cast<double>(done) / drive.frames(), "frame " + std::to_string(done));
        interrupt.check();
      });
}

/** All files appear together, or none. */
void simulate(const Options& o)
{
  const World world = guarded(o.world, kSimplerWorld, [&] { return load_world(o.world); });
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
  char way[40];
  std::snprintf(way, sizeof way, "%.1f m", drive.path().distance_m(end_s));
  std::cout << world.name << ": " << drive.frames() << " frames of " << drive.scanner().name
            << " over " << way << " -> "
            << (fs::path(o.output) / (name_of_world(o.world) + ".rawlog")).string() << "\n";
}

}  // namespace

int main(int argc, char** argv)
{
  const PrintableOutput printable;
  Options options;
  if (const auto exit_code = parse_options(argc, argv, options)) return *exit_code;
  try
  {
    simulate(options);
  }
  catch (const Interrupted& e)
  {
    std::cerr << "talus-sim: stopped; nothing was written\n";
    return 128 + e.signal;
  }
  catch (const std::exception& e)
  {
    std::cerr << "talus-sim: " << failure_text(e, options.world, kSimplerWorld) << "\n";
    return 1;
  }
  return 0;
}
