#include "floor.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace talus::bench
{
namespace
{
void transform_and_bin(
    const Load& load, const Scan& scan, std::vector<int>& count, std::vector<float>& height)
{
  const auto& m = scan.T_map_sensor.m;
  float r[12];
  for (std::size_t i = 0; i < 12; i++) r[i] = static_cast<float>(m[i]);
  const float inverse = static_cast<float>(1 / load.resolution_m);
  const float half = 0.5f * static_cast<float>(load.cells);
  for (std::size_t i = 0; i < scan.x_m.size(); i++)
  {
    const float x = scan.x_m[i], y = scan.y_m[i], z = scan.z_m[i];
    const float cx = (r[0] * x + r[1] * y + r[2] * z) * inverse + half;
    const float cy = (r[4] * x + r[5] * y + r[6] * z) * inverse + half;
    const float n = static_cast<float>(load.cells);
    if (!(cx >= 0 && cx < n && cy >= 0 && cy < n)) continue;
    const int cell = static_cast<int>(cy) * load.cells + static_cast<int>(cx);
    count[static_cast<std::size_t>(cell)]++;
    height[static_cast<std::size_t>(cell)] = r[8] * x + r[9] * y + r[10] * z + r[11];
  }
}
}  // namespace

double quantile(std::vector<double> sample, double q)
{
  const auto at = static_cast<std::size_t>(q * static_cast<double>(sample.size() - 1) + 0.5);
  std::nth_element(sample.begin(), sample.begin() + static_cast<std::ptrdiff_t>(at), sample.end());
  return sample[at];
}

double cpu_floor_s(const Load& load, const Scan& scan)
{
  const auto cells = static_cast<std::size_t>(load.cells) * static_cast<std::size_t>(load.cells);
  std::vector<int> count(cells);
  std::vector<float> height(cells), out(cells);
  std::vector<double> seconds;
  for (int i = 0; i < 21; i++)
  {
    const auto start = std::chrono::steady_clock::now();
    transform_and_bin(load, scan, count, height);
    for (std::size_t c = 0; c < cells; c++)
      out[c] = count[c] > 0 ? height[c] : out[c], count[c] = 0;
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
    seconds.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return quantile(seconds, 0.5);
}

}  // namespace talus::bench
