#include <talus/elevation_mapper.h>
#include "baselines.h"
#include "floor.h"
#include "measure.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>
#include <stdexcept>

// One line a setting and backend: the whole frame (host points in, layers back), its quantiles by
// the clock, the median of its processor time (cpu_us), the mean time of each stage (those that run
// fused count for the first), and how many times the reference it takes: to transform and bin the
// same points, and to pass once over the window for each layer, timed in the same run (on a device:
// launch and copy). A core is compared by processor time, a device by the clock. x_S1: for each
// point and cell, against S1.

using namespace talus;
using namespace talus::bench;

namespace
{
/** Cost of a frame [s] of the lines so far, by prefix/name: what later lines are compared with. */
std::map<std::string, double>& costs_s()
{
  static std::map<std::string, double> all;
  return all;
}

CellRect columns(const Window& w, int first, int width)
{
  return {w.min_cell_x + first, w.min_cell_y, width, w.cells};
}

/** update(), with cells of a window that moves along x: with those that leave it others by which
 * they are judged, with those that come into it those beside them. */
FrameReport hand_over(ElevationMapper& map, const Frame& frame, HandedOver handed_over)
{
  constexpr int kMargin = 4;
  const Window before = map.window(), after = map.window_after(frame);
  const auto moved = static_cast<int>(after.min_cell_x - before.min_cell_x);
  const int n = before.cells, width = std::abs(moved), kept = width + kMargin;
  const CellRect came = columns(after, moved > 0 ? n - width : 0, width);
  FrameCells cells;
  cells.before = {columns(before, moved > 0 ? 0 : n - kept, kept)};
  cells.after = {came, columns(after, moved > 0 ? n - width - 1 : width, 1)};
  const FrameReport report = map.update(frame, cells);
  if (handed_over == HandedOver::ReadAndWritten)
    map.write_cells({came}, cells.records_after.first, came.size());
  return report;
}

/** Updates with a frame; where they overlap, starts it and finishes the one before. */
FrameReport run_frame(ElevationMapper& map, const Frame& frame, const Setting& s)
{
  if (s.overlapped && map.frames_in_flight() == 0) map.start(frame);
  if (s.overlapped) map.start(frame);
  const bool hands_over = s.cells_handed_over != HandedOver::Nothing && !map.empty();
  const FrameReport report = s.overlapped ? map.finish()
                             : hands_over ? hand_over(map, frame, s.cells_handed_over)
                                          : map.update(frame);
  for (const Layer l : s.layers) benchmark::DoNotOptimize(map.layer(l).data());
  return report;
}

/** What the frames of a line took. */
struct Times
{
  std::vector<double> seconds, cpu_seconds;
  std::array<double, kStageCount> stage_ms{};

  void add(double frame_s, double frame_cpu_s, const FrameReport& report)
  {
    seconds.push_back(frame_s);
    cpu_seconds.push_back(frame_cpu_s);
    for (std::size_t k = 0; k < stage_ms.size(); k++) stage_ms[k] += report.stage_ms[k];
  }
};

void count_frames(benchmark::State& state, const Setting& s, const Times& times, double cost_s)
{
  const double median_s = quantile(times.seconds, 0.5);
  auto& counters = state.counters;
  counters["median_us"] = 1e6 * median_s;
  counters["cpu_us"] = 1e6 * quantile(times.cpu_seconds, 0.5);
  counters["p99_us"] = 1e6 * quantile(times.seconds, 0.99);
  counters["ns_per_point_and_cell"] = 1e9 * cost_s / s.points_and_cells();
  counters["points/s"] = static_cast<double>(s.points) / median_s;
  counters["cells/s"] = static_cast<double>(s.cells) * s.cells / median_s;
  const auto frames = static_cast<double>(times.seconds.size());
  for (std::size_t i = 0; i < kStageNames.size(); i++)
    if (times.stage_ms[i] > 0)
      counters[std::to_string(i + 1) + "_" + kStageNames[i] + "_us"] =
          1e3 * times.stage_ms[i] / frames;
}

/** Against S1. */
void compare(benchmark::State& state, const Setting& s, const std::string& prefix, double cost_s)
{
  auto& known = costs_s();
  known[prefix + "/" + s.name] = cost_s;
  const Setting S1 = settings().front();
  if (const auto at = known.find(prefix + "/" + S1.name); at != known.end())
    state.counters["x_S1"] = cost_s / s.points_and_cells() / (at->second / S1.points_and_cells());
}

void count_reference(benchmark::State& state, double cost_s, double reference_s)
{
  state.counters["reference_us"] = 1e6 * reference_s;
  state.counters["x_reference"] = cost_s / reference_s;
}

void bench_frame(
    benchmark::State& state, const Setting& s, Backend backend, const std::string& prefix)
{
  constexpr int kWarm = 8, kReferences = 5;
  constexpr double kWarm_s = 1;
  ElevationMapper map(parameters(s), backend, 1);
  map.set_output_layers(s.layers);
  CpuFloor floor(s);
  int i = 0;
  // Long enough for the processor's clock to settle, too.
  const double warm_until_s = process_cpu_s() + kWarm_s;
  for (; i < kWarm || process_cpu_s() < warm_until_s; i++) run_frame(map, scan_at(s, i).frame(), s);
  Times times;
  const int every = std::max(1, static_cast<int>(state.max_iterations) / kReferences);
  for (auto _ : state)
  {
    const Frame frame = scan_at(s, i++).frame();
    const double cpu_s = process_cpu_s();
    const auto start = std::chrono::steady_clock::now();
    const FrameReport report = run_frame(map, frame, s);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    times.add(took.count(), process_cpu_s() - cpu_s, report);
    state.SetIterationTime(took.count());
    if (backend == Backend::Cpu && times.seconds.size() % static_cast<std::size_t>(every) == 0)
      floor.sample();
  }
  // A core is compared by processor time: what else the machine does is not its cost.
  const bool on_core = backend == Backend::Cpu;
  const double cost_s = quantile(on_core ? times.cpu_seconds : times.seconds, 0.5);
  count_frames(state, s, times, cost_s);
  compare(state, s, prefix, cost_s);
  if (backend == Backend::Cpu)
  {
    count_reference(state, cost_s, floor.frame_s());
    state.counters["reference_points_us"] = 1e6 * floor.points_s();
    state.counters["reference_pass_us"] = 1e6 * floor.pass_s();
  }
  else if (const auto device = cuda_floor_s(s.points, s.cells, static_cast<int>(s.layers.size())))
    count_reference(state, cost_s, *device);
}

void bench_baseline(benchmark::State& state, const Setting& s, const Baseline& baseline)
{
  CpuFloor floor(s);
  for (auto _ : state)
  {
    floor.sample();
    const double frame_s = baseline.frame_s(s);
    floor.sample();
    state.SetIterationTime(frame_s);
    state.counters["cpu_us"] = 1e6 * frame_s;
    count_reference(state, frame_s, floor.frame_s());
    if (const auto at = costs_s().find("cpu/" + s.name); at != costs_s().end())
      state.counters["x_talus"] = frame_s / at->second;
  }
}

/** Enough for quantiles, within a second or two. */
int iterations(const Setting& s, Backend backend)
{
  const double frames = (backend == Backend::Cpu ? 1e7 : 4e8) / s.points_and_cells();
  return static_cast<int>(std::min(std::max(frames, 5.0), 2000.0));
}

void add(const Setting& s, Backend backend, const std::string& prefix)
{
  if (backend == Backend::Cpu && s.overlapped) return;
  benchmark::RegisterBenchmark(
      ("frame/" + prefix + "/" + s.name).c_str(),
      [s, backend, prefix](benchmark::State& state) { bench_frame(state, s, backend, prefix); })
      ->UseManualTime()
      ->Iterations(iterations(s, backend))
      ->Unit(benchmark::kMicrosecond);
}

void add(const Setting& s, const Baseline& baseline)
{
  benchmark::RegisterBenchmark(
      ("baseline/" + baseline.name + "/" + s.name).c_str(),
      [s, baseline](benchmark::State& state) { bench_baseline(state, s, baseline); })
      ->UseManualTime()
      ->Iterations(1)
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
  for (const Baseline& b : baselines()) add(settings().front(), b);
  if (has_cuda())
    for (const Setting& s : settings()) add(s, Backend::Cuda, "cuda");
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::ConsoleReporter table(benchmark::ConsoleReporter::OO_Tabular);
  benchmark::RunSpecifiedBenchmarks(&table);
  benchmark::Shutdown();
}
