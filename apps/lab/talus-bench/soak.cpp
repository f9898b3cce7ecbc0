#include <talus/elevation_mapper.h>
#include "../../common/command_line.h"
#include "measure.h"
#include "scans.h"

#include <sys/resource.h>
#ifdef TALUS_HAS_SITES
#include <talus/site/site_mapper.h>
#endif

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

// Drives for hours and looks whether anything creeps: the time of a frame, memory, the place of the
// window, the map itself.

namespace fs = std::filesystem;
using namespace talus;
using namespace talus::bench;

namespace
{
constexpr int kWindow = 1000;  //!< frames whose quantiles are taken together
constexpr int kStep_cells = 28;  //!< 1.4 m a frame: 100 km in an hour at 20 Hz
constexpr int kRoad_cells = 320;
constexpr std::size_t kPoints = 14400;
constexpr double kMB = 1024 * 1024;
constexpr double kAllowedGrowth_MB = 1;
constexpr double kAllowedIndex_MB_per_km = 0.15;  //!< of tiles on disk, and the way
constexpr double kAllowedOfTiles = 0.1;  //!< so much the allocator adds to packed tiles

struct Options
{
  int frames = 72000;
  Backend backend = Backend::Cpu;
  double max_ratio = 2;
  bool whole = false;
  double memory_MB = 512;
  std::string folder = ".";
};

double mean(const std::vector<double>& sample)
{
  return std::accumulate(sample.begin(), sample.end(), 0.0) / static_cast<double>(sample.size());
}

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

#ifdef TALUS_HAS_SITES
/** All of a drive, kept in tiles; those for which there is no memory go to a folder. */
class Whole
{
 public:
  Whole(double resolution_m, double memory_MB, const std::string& folder)
      : folder_(folder),
        site_(resolution_m, static_cast<std::size_t>(memory_MB * kMB), folder),
        mapper_(site_)
  {
  }
  /** map.update(frame), and what leaves is kept. */
  void update(ElevationMapper& map, const Frame& frame) { mapper_.update(map, frame); }
  std::size_t tiles() const { return site_.tiles.keys().size(); }
  double tiles_MB() const  //!< in memory
  {
    const site::TileStore::Memory memory = site_.tiles.memory();
    return static_cast<double>(memory.open + memory.packed) / kMB;
  }
  double disk_MB() const
  {
    std::uintmax_t bytes = 0;
    if (!fs::exists(folder_)) return 0;
    for (const fs::directory_entry& hidden : fs::directory_iterator(folder_))
      if (hidden.is_directory() && hidden.path().filename().string().rfind(".talus-tiles.", 0) == 0)
        for (const fs::directory_entry& tile : fs::directory_iterator(hidden.path()))
          bytes += tile.file_size();
    return static_cast<double>(bytes) / kMB;
  }

 private:
  std::string folder_;
  site::Site site_;
  site::SiteMapper mapper_;
};
#else
/** Without MRPT there are no sites. */
struct Whole
{
  Whole(double, double, const std::string&)
  {
    throw std::runtime_error("--whole needs a talus that is built with TALUS_WITH_MRPT=ON");
  }
  void update(ElevationMapper&, const Frame&) {}
  std::size_t tiles() const { return 0; }
  double tiles_MB() const { return 0; }
  double disk_MB() const { return 0; }
};
#endif

/** What a thousand frames took, by processor time: what else the machine does is not their cost. */
struct Pace
{
  double median_ms = 0, p99_ms = 0, mean_ms = 0;
  double memory_MB = 0, tiles_MB = 0;  //!< tiles_MB: of that
  double ratio() const { return p99_ms / median_ms; }
};

class Soak
{
 public:
  explicit Soak(const Options& o) : options_(o), road_(parameters_), map_(make_map())
  {
    if (o.whole) whole_ = std::make_unique<Whole>(parameters_.resolution_m, o.memory_MB, o.folder);
  }

  /** Prints a line a window and what came out; true when all is well. */
  bool run()
  {
    std::puts(
        "  frames     median ms   p99 ms   p99/median   mean ms   peak MB   of processor time");
    for (int i = 0; i < options_.frames;)
    {
      paces_.push_back(drive(i, std::min(i + kWindow, options_.frames)));
      i = std::min(i + kWindow, options_.frames);
      const Pace& p = paces_.back();
      std::printf(
          "%8d %13.3f %8.3f %12.2f %9.3f %9.1f\n", i, p.median_ms, p.p99_ms, p.ratio(), p.mean_ms,
          p.memory_MB);
      std::fflush(stdout);
    }
    return report();
  }

 private:
  ElevationMapper make_map() const
  {
    ElevationMapper map(parameters_, options_.backend, 1);
    map.set_output_layers({Layer::Traversability, Layer::Elevation});
    return map;
  }

  Pace drive(int begin, int end)
  {
    std::vector<double> ms;
    for (int i = begin; i < end; i++)
    {
      const Frame frame = road_[i];
      const double before_s = process_cpu_s();
      if (whole_)
        whole_->update(map_, frame);
      else
        map_.update(frame);
      ms.push_back(1e3 * (process_cpu_s() - before_s));
      const Window w = map_.window();
      if (w.min_cell_x != Road::cell(i) - w.cells / 2 || w.min_cell_y != -w.cells / 2) strayed_++;
    }
    return {
        quantile(ms, 0.5), quantile(ms, 0.99), mean(ms), peak_memory_MB(),
        whole_ ? whole_->tiles_MB() : 0};
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
    const double km = 1e-3 * kStep_cells * parameters_.resolution_m * options_.frames;
    std::printf("\n%d frames, %.1f km, %s\n", options_.frames, km, map_.backend_name().c_str());
    const bool steady = is_steady();
    const bool flat = memory_is_flat(km), same = same_as_a_fresh_map();
    say(strayed_ == 0, std::to_string(strayed_) + " frames whose window was not where it belongs");
    say(same, std::string("the map is ") + (same ? "" : "not ") +
                  "that of a fresh one fed with the last frames, bit by bit");
    return steady && flat && strayed_ == 0 && same;
  }
  /** Where tiles go to disk a frame takes longer than others, at kilometre 100 as at 10: then means
   * of 1,000 are compared. */
  bool is_steady() const
  {
    std::vector<double> means, ratios;
    for (const Pace& p : paces_) means.push_back(p.mean_ms), ratios.push_back(p.ratio());
    const double worst = whole_ ? quantile(means, 1) / quantile(means, 0.5) : quantile(ratios, 1);
    return say(
        worst <= options_.max_ratio,
        text(
            whole_ ? "slowest 1,000 frames / median of them: %.2f; %.3g allowed"
                   : "worst p99/median: %.2f; %.3g allowed",
            worst, options_.max_ratio));
  }
  bool memory_is_flat(double km) const
  {
    const Pace &first = paces_.front(), &last = paces_.back();
    const double growth_MB = last.memory_MB - first.memory_MB;
    if (!whole_)
      return say(
          growth_MB <= kAllowedGrowth_MB,
          text("memory grew by %.1f MB since the first window", growth_MB));
    const double beside_MB = growth_MB - (last.tiles_MB - first.tiles_MB);
    const double disk_MB = whole_->disk_MB();
    std::printf(
        "  %zu tiles; on disk %.0f MB, %.1f a km driven\n", whole_->tiles(), disk_MB, disk_MB / km);
    return say(
        last.tiles_MB <= options_.memory_MB && beside_MB <= kAllowedGrowth_MB +
                                                                kAllowedIndex_MB_per_km * km +
                                                                kAllowedOfTiles * last.tiles_MB,
        text(
            "%.0f MB of tiles in memory, %.0f allowed; beside them it grew by %.1f MB",
            last.tiles_MB, options_.memory_MB, beside_MB));
  }

  template <class... Value>
  static std::string text(const char* format, Value... values)
  {
    char line[160];
    std::snprintf(line, sizeof line, format, values...);
    return line;
  }
  static bool say(bool well, const std::string& what)
  {
    std::printf("  %-6s %s\n", well ? "ok" : "FAILED", what.c_str());
    return well;
  }

  const Options& options_;
  Parameters parameters_;
  Road road_;
  ElevationMapper map_;
  std::unique_ptr<Whole> whole_;
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
      "  talus-soak --whole --memory 64            # all of it kept in tiles",
      "talus-soak");
  app.add_option("--frames", o.frames, "how many")
      ->check(CLI::Range(2, 10000000))
      ->capture_default_str();
  app.add_option(
         "--max-ratio", o.max_ratio,
         "allowed p99/median of a frame's processor time, in any 1,000 frames")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  auto* whole = app.add_flag(
      "--whole", o.whole,
      "keep all of the drive in tiles: then the mean of no 1,000 frames is more than --max-ratio "
      "times that of others, and memory stays within the budget");
  app.add_option("--memory", o.memory_MB, "of the tiles [MB]; others go to disk")
      ->check(CLI::Range(4.0, 1e7))
      ->needs(whole)
      ->capture_default_str();
  app.add_option("--folder", o.folder, "of the tiles on disk, removed at the end: 45 MB a km")
      ->needs(whole)
      ->capture_default_str();
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
