#include <talus/elevation_mapper.h>
#include "floor.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>
#include <stdexcept>

// One line a setting and backend: the whole frame (host points in, layers back), its quantiles, the
// time of each stage, and how many times the floor it takes.

using namespace talus;
using namespace talus::bench;

namespace
{
struct Setting
{
  std::string name;
  std::size_t points;
  int cells;  //!< along each side
  std::vector<Layer> layers;
  bool in_place = false;  //!< the points are in ElevationMapper::point_arrays() already
  FillRule fill_rule = Parameters{}.fill_rule;
};

const std::vector<Layer> kTwoLayers{Layer::Traversability, Layer::Elevation};
const std::vector<Layer> kSixLayers{Layer::Traversability, Layer::Elevation, Layer::GroundElevation,
                                    Layer::Variance,       Layer::State,     Layer::Slope};
constexpr double kResolution_m = 0.05;

std::vector<Setting> settings()
{
  std::vector<Setting> all{
      {"S1", 14400, 160, kTwoLayers},
      {"S1/6_layers", 14400, 160, kSixLayers},
      {"S2", 131072, 1000, kTwoLayers},
      {"S2/6_layers", 131072, 1000, kSixLayers},
      {"S1/in_place", 14400, 160, kTwoLayers, true},
      {"S2/in_place", 131072, 1000, kTwoLayers, true},
      {"S2/6_layers/in_place", 131072, 1000, kSixLayers, true},
      {"S1/exchanged", 14400, 160, kTwoLayers, false, FillRule::Exchanged},
      {"S2/exchanged", 131072, 1000, kTwoLayers, false, FillRule::Exchanged}};
  for (const std::size_t points : {10240, 51200, 204800, 819200, 2048000})
    all.push_back({"points/" + std::to_string(points), points, 400, kTwoLayers});
  for (const int cells : {160, 400, 1000, 2000, 4000})
    all.push_back({"cells/" + std::to_string(cells), 131072, cells, kTwoLayers});
  return all;
}

/** The drive of a setting, made once. */
const std::vector<Scan>& drive(const Setting& s)
{
  static std::map<std::string, std::vector<Scan>> made;
  const double radius_m = 0.55 * s.cells * kResolution_m;
  const std::string key = std::to_string(s.points) + "/" + std::to_string(s.cells);
  auto& scans = made[key];
  if (scans.empty()) scans = make_drive(s.points, radius_m, s.points > 200000 ? 3 : 8);
  return scans;
}

Parameters parameters(const Setting& s)
{
  Parameters p;
  p.resolution_m = kResolution_m;
  p.window_m = s.cells * kResolution_m;
  p.fill_rule = s.fill_rule;
  return p;
}

/** Forth and back, so that the window rolls in every frame and the drive never ends. */
const Scan& scan_at(const std::vector<Scan>& scans, int i)
{
  const int last = static_cast<int>(scans.size()) - 1, at = i % (2 * last);
  return scans[static_cast<std::size_t>(at <= last ? at : 2 * last - at)];
}

/** The scan as a frame; where it is wanted in place, it is put there first. */
Frame frame_of(ElevationMapper& map, const Scan& scan, const Setting& s)
{
  Frame frame = scan.frame();
  if (!s.in_place) return frame;
  const PointArrays to = map.point_arrays(frame.size);
  frame.x_m = std::copy_n(frame.x_m, frame.size, to.x_m) - frame.size;
  frame.y_m = std::copy_n(frame.y_m, frame.size, to.y_m) - frame.size;
  frame.z_m = std::copy_n(frame.z_m, frame.size, to.z_m) - frame.size;
  return frame;
}

FrameReport run_frame(ElevationMapper& map, const Frame& frame, const Setting& s)
{
  const FrameReport report = map.update(frame);
  for (const Layer l : s.layers) benchmark::DoNotOptimize(map.layer(l).data());
  return report;
}

double floor_s(const Setting& s, Backend backend)
{
  const Load load{s.points, s.cells, kResolution_m, static_cast<int>(s.layers.size())};
  if (backend == Backend::Cpu) return cpu_floor_s(load, drive(s).front());
  return cuda_floor_s(load).value_or(0.0);
}

void count(
    benchmark::State& state, const Setting& s, std::vector<double> seconds,
    const std::array<double, kStageCount>& stage_ms, double floor)
{
  const double median = quantile(seconds, 0.5), frames = static_cast<double>(seconds.size());
  state.counters["median_us"] = 1e6 * median;
  state.counters["p99_us"] = 1e6 * quantile(std::move(seconds), 0.99);
  state.counters["floor_us"] = 1e6 * floor;
  state.counters["x_floor"] = median / floor;
  state.counters["points/s"] = static_cast<double>(s.points) / median;
  state.counters["cells/s"] = static_cast<double>(s.cells) * s.cells / median;
  for (std::size_t i = 0; i < stage_ms.size(); i++)
    if (stage_ms[i] > 0)
      state.counters[std::to_string(i + 1) + "_" + kStageNames[i] + "_us"] =
          1e3 * stage_ms[i] / frames;
}

void bench_frame(benchmark::State& state, const Setting& s, Backend backend)
{
  const auto& scans = drive(s);
  ElevationMapper map(parameters(s), backend, 1);
  map.set_output_layers(s.layers);
  int i = 0;
  for (; i < 8; i++) run_frame(map, frame_of(map, scan_at(scans, i), s), s);
  std::vector<double> seconds;
  std::array<double, kStageCount> stage_ms{};
  for (auto _ : state)
  {
    const Frame frame = frame_of(map, scan_at(scans, i++), s);
    const auto start = std::chrono::steady_clock::now();
    const FrameReport report = run_frame(map, frame, s);
    seconds.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    state.SetIterationTime(seconds.back());
    for (std::size_t k = 0; k < stage_ms.size(); k++) stage_ms[k] += report.stage_ms[k];
  }
  count(state, s, std::move(seconds), stage_ms, floor_s(s, backend));
}

/** Enough for quantiles, within a second or two. */
int iterations(const Setting& s, Backend backend)
{
  const double work = static_cast<double>(s.points) + static_cast<double>(s.cells) * s.cells;
  const double frames = (backend == Backend::Cpu ? 1e7 : 4e8) / work;
  return static_cast<int>(std::min(std::max(frames, 5.0), 2000.0));
}

void add(const Setting& s, Backend backend, const std::string& prefix)
{
  benchmark::RegisterBenchmark(
      ("frame/" + prefix + "/" + s.name).c_str(),
      [s, backend](benchmark::State& state) { bench_frame(state, s, backend); })
      ->UseManualTime()
      ->Iterations(iterations(s, backend))
      ->Unit(benchmark::kMicrosecond);
}

bool has_cuda()
{
  try
  {
    std::cerr << "device: " << ElevationMapper({}, Backend::Cuda).backend_name() << "\n";
    return true;
  }
  catch (const std::runtime_error& e)
  {
    std::cerr << "no CUDA lines: " << e.what() << "\n";
    return false;
  }
}
}  // namespace

int main(int argc, char** argv)
{
  for (const Setting& s : settings()) add(s, Backend::Cpu, "cpu");
  if (has_cuda())
    for (const Setting& s : settings()) add(s, Backend::Cuda, "cuda");
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
