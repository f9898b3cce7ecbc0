#include "floor.h"

#include <benchmark/benchmark.h>

#include "measure.h"

namespace talus::bench
{
namespace
{
constexpr int kRepetitions = 5;

template <class Body>
double seconds_of(const Body& body)
{
  const double start = process_cpu_s();
  body();
  benchmark::ClobberMemory();
  return process_cpu_s() - start;
}
}  // namespace

CpuFloor::CpuFloor(const Setting& setting) : setting_(setting)
{
  const auto n = static_cast<std::size_t>(setting.cells);
  count_.resize(n * n);
  height_.resize(n * n);
  out_.resize(n * n);
}

void CpuFloor::transform_and_bin()
{
  const Scan& scan = scan_at(setting_, 0);
  const auto& m = scan.T_map_sensor.m;
  float r[12];
  for (std::size_t i = 0; i < 12; i++) r[i] = static_cast<float>(m[i]);
  const float inverse = static_cast<float>(1 / parameters(setting_).resolution_m);
  const float n = static_cast<float>(setting_.cells), half = 0.5f * n;
  for (std::size_t i = 0; i < scan.x_m.size(); i++)
  {
    const float x = scan.x_m[i], y = scan.y_m[i], z = scan.z_m[i];
    const float cx = (r[0] * x + r[1] * y + r[2] * z) * inverse + half;
    const float cy = (r[4] * x + r[5] * y + r[6] * z) * inverse + half;
    if (!(cx >= 0 && cx < n && cy >= 0 && cy < n)) continue;
    const int cell = static_cast<int>(cy) * setting_.cells + static_cast<int>(cx);
    count_[static_cast<std::size_t>(cell)]++;
    height_[static_cast<std::size_t>(cell)] = r[8] * x + r[9] * y + r[10] * z + r[11];
  }
}

void CpuFloor::pass()
{
  for (std::size_t c = 0; c < out_.size(); c++)
    out_[c] = count_[c] > 0 ? height_[c] : out_[c], count_[c] = 0;
  benchmark::DoNotOptimize(out_.data());
}

void CpuFloor::sample()
{
  transform_and_bin();  // what a frame has pushed out of the cache comes back
  pass();
  for (int i = 0; i < kRepetitions; i++)
  {
    points_samples_s_.push_back(seconds_of([this] { transform_and_bin(); }));
    pass_samples_s_.push_back(seconds_of([this] { pass(); }));
  }
}

double CpuFloor::points_s() const { return quantile(points_samples_s_, 0.5); }
double CpuFloor::pass_s() const { return quantile(pass_samples_s_, 0.5); }
double CpuFloor::frame_s() const
{
  return points_s() + static_cast<double>(setting_.layers.size()) * pass_s();
}

}  // namespace talus::bench
