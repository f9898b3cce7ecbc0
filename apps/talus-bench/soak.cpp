#include <talus/elevation_mapper.h>
#include "../common/command_line.h"
#include "measure.h"
#include "scans.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

// Drives for hours and looks whether anything creeps: the time of a frame, memory, the place of the
// window, the map itself.

using namespace talus;
using namespace talus::bench;

namespace
{
constexpr int kWindow = 1000;  //!< frames whose quantiles are taken together
constexpr int kStep_cells = 28;  //!< 1.4 m a frame: 100 km in an hour at 20 Hz
constexpr int kRoad_cells = 320;
constexpr std::size_t kPoints = 14400;
constexpr double kAllowedGrowth_MB = 1;

struct Options
{
  int frames = 72000, threads = 1;
  Backend backend = Backend::Cpu;
  double max_ratio = 2;
  bool by_clock = false;
};

double peak_memory_MB()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/** Frame i of the drive: the sensor in the middle of a cell, so that its place is exact. */
class Road
{
 public:
  explicit Road(const Parameters& p) : resolution_m_(p.resolution_m)
  {
    scans_ =
        make_road(kPoints, p.window_m, kRoad_cells * p.resolution_m, kStep_cells * p.resolution_m);
  }
  static std::int64_t cell(int i) { return std::int64_t{kStep_cells} * i; }
  Frame operator[](int i) const
  {
    Frame frame = scans_[static_cast<std::size_t>(i) % scans_.size()].frame();
    frame.stamp_s = 0.05 * i;
    frame.T_map_sensor.m[3] = (static_cast<double>(cell(i)) + 0.5) * resolution_m_;
    frame.T_map_sensor.m[7] = 0.5 * resolution_m_;
    return frame;
  }

 private:
  double resolution_m_;
  std::vector<Scan> scans_;
};

/** What a thousand frames took. */
struct Pace
{
  double median_ms = 0, p99_ms = 0, cpu_median_ms = 0, cpu_p99_ms = 0, memory_MB = 0;
  double ratio() const { return p99_ms / median_ms; }
  double cpu_ratio() const { return cpu_p99_ms / cpu_median_ms; }
};

class Soak
{
 public:
  explicit Soak(const Options& o) : options_(o), road_(parameters_), map_(make_map()) {}

  /** Prints a line a window and what came out; true when all is well. */
  bool run()
  {
    std::puts("  frames     median ms   p99 ms   p99/median   of CPU time   peak MB");
    for (int i = 0; i < options_.frames;)
    {
      paces_.push_back(drive(i, std::min(i + kWindow, options_.frames)));
      i = std::min(i + kWindow, options_.frames);
      const Pace& p = paces_.back();
      std::printf(
          "%8d %13.3f %8.3f %12.2f %13.2f %9.1f\n", i, p.median_ms, p.p99_ms, p.ratio(),
          p.cpu_ratio(), p.memory_MB);
      std::fflush(stdout);
    }
    return report();
  }

 private:
  ElevationMapper make_map() const
  {
    ElevationMapper map(parameters_, options_.backend, options_.threads);
    map.set_output_layers({Layer::Traversability, Layer::Elevation});
    return map;
  }

  Pace drive(int begin, int end)
  {
    std::vector<double> ms, cpu_ms;
    for (int i = begin; i < end; i++)
    {
      const Frame frame = road_[i];
      const double cpu_s = process_cpu_s();
      const auto start = std::chrono::steady_clock::now();
      map_.update(frame);
      ms.push_back(
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
              .count());
      cpu_ms.push_back(1e3 * (process_cpu_s() - cpu_s));
      const Window w = map_.window();
      if (w.min_cell_x != Road::cell(i) - w.cells / 2 || w.min_cell_y != -w.cells / 2) strayed_++;
    }
    return {
        quantile(ms, 0.5), quantile(ms, 0.99), quantile(cpu_ms, 0.5), quantile(cpu_ms, 0.99),
        peak_memory_MB()};
  }

  /** Whether a map that only ever saw the last frames is the same, bit by bit. */
  bool same_as_a_fresh_map() const
  {
    ElevationMapper fresh = make_map();
    const int frames = 2 * parameters_.cells() / kStep_cells + 1;
    for (int i = std::max(0, options_.frames - frames); i < options_.frames; i++)
      fresh.update(road_[i]);
    return fresh.save() == map_.save();
  }

  bool report() const
  {
    double clock = 0, cpu = 0;
    for (const Pace& p : paces_)
      clock = std::max(clock, p.ratio()), cpu = std::max(cpu, p.cpu_ratio());
    const double growth_MB = paces_.back().memory_MB - paces_.front().memory_MB;
    const double km = 1e-3 * kStep_cells * parameters_.resolution_m * options_.frames;
    const bool steady = (options_.by_clock ? clock : cpu) <= options_.max_ratio,
               flat = growth_MB <= kAllowedGrowth_MB;
    const bool same = same_as_a_fresh_map();
    char text[128];
    std::printf(
        "\n%d frames, %.1f km, %s, %d %s\n", options_.frames, km, map_.backend_name().c_str(),
        options_.threads, options_.threads == 1 ? "thread" : "threads");
    std::snprintf(
        text, sizeof text,
        "worst p99/median %.2f by processor time, %.2f by the clock; %.3g allowed", cpu, clock,
        options_.max_ratio);
    say(steady, text);
    std::snprintf(text, sizeof text, "memory grew by %.1f MB since the first window", growth_MB);
    say(flat, text);
    say(strayed_ == 0, std::to_string(strayed_) + " frames whose window was not where it belongs");
    say(same, std::string("the map is ") + (same ? "" : "not ") +
                  "that of a fresh one fed with the last frames, bit by bit");
    return steady && flat && strayed_ == 0 && same;
  }
  static void say(bool well, const std::string& what)
  {
    std::printf("  %-6s %s\n", well ? "ok" : "FAILED", what.c_str());
  }

  const Options& options_;
  Parameters parameters_;
  Road road_;
  ElevationMapper map_;
  std::vector<Pace> paces_;
  int strayed_ = 0;
};
}  // namespace

int main(int argc, char** argv)
{
  Options o;
  CLI::App app(
      "Feeds a map with an hour of frames (the setting S1) along 100 km of road, and fails when "
      "the\n"
      "time of a frame, the memory, the place of the window or the map itself creep.\n\n"
      "  talus-soak                                # 72,000 frames\n"
      "  talus-soak --by-clock                     # on a machine that does nothing else",
      "talus-soak");
  app.add_option("--frames", o.frames, "how many")
      ->check(CLI::Range(2, 10000000))
      ->capture_default_str();
  app.add_option(
         "--max-ratio", o.max_ratio, "allowed p99/median of a frame's time, in any 1,000 frames")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag(
      "--by-clock", o.by_clock,
      "judge that by the clock; else by processor time, in which "
      "other work on the machine does not count");
  app.add_option("--threads", o.threads, "of the CPU backend")->check(CLI::Range(1, 256));
  const std::map<std::string, Backend> backends{{"cpu", Backend::Cpu}, {"cuda", Backend::Cuda}};
  app.add_option("--backend", o.backend, "cpu or cuda")->transform(CLI::Transformer(backends));
  if (const auto exit_code = app::parse_command_line(app, argc, argv)) return *exit_code;
  try
  {
    return Soak(o).run() ? 0 : 1;
  }
  catch (const std::runtime_error& e)
  {
    std::fprintf(stderr, "talus-soak: %s\n", e.what());
    return 1;
  }
}
