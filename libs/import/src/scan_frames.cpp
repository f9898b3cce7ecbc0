#include "placed_scans.h"

#include <talus/io/quantile.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

using mrpt::poses::CPose3D;

namespace talus::import
{
bool is_in_world(const ImportedScan& scan) { return scan.origin_m != std::array<double, 3>{}; }

void bring_to_sensor(const CPose3D& T_map_sensor, ImportedScan& scan)
{
  const auto& R = T_map_sensor.getRotationMatrix();
  const std::array<double, 3> shift_m = {
      scan.origin_m[0] - T_map_sensor.x(), scan.origin_m[1] - T_map_sensor.y(),
      scan.origin_m[2] - T_map_sensor.z()};
  for (std::size_t i = 0; i < scan.x_m.size(); ++i)
  {
    const double x = scan.x_m[i] + shift_m[0], y = scan.y_m[i] + shift_m[1],
                 z = scan.z_m[i] + shift_m[2];
    scan.x_m[i] = static_cast<float>(R(0, 0) * x + R(1, 0) * y + R(2, 0) * z);
    scan.y_m[i] = static_cast<float>(R(0, 1) * x + R(1, 1) * y + R(2, 1) * z);
    scan.z_m[i] = static_cast<float>(R(0, 2) * x + R(1, 2) * y + R(2, 2) * z);
  }
  scan.origin_m = {};
}

CPose3D base_below(const ImportedScan& scan)
{
  constexpr double kAround_m = 5, kLow = 0.05;
  constexpr std::size_t kMinCount = 20;
  std::vector<double> near_m, all_m;
  for (std::size_t i = 0; i < scan.x_m.size(); ++i)
  {
    all_m.push_back(scan.z_m[i]);
    if (std::hypot(scan.x_m[i], scan.y_m[i]) < kAround_m) near_m.push_back(scan.z_m[i]);
  }
  auto& heights_m = near_m.size() < kMinCount ? all_m : near_m;
  const double low_m = scan.origin_m[2] + io::quantile(heights_m, kLow);
  const double ground_m = std::round(100 * low_m) / 100;
  return {scan.origin_m[0], scan.origin_m[1], ground_m, 0, 0, 0};
}

double median_range_m(const ImportedScan& scan, const std::array<double, 3>& from_m)
{
  constexpr std::size_t kEnough = 2000;
  const std::size_t step = scan.x_m.size() / kEnough + 1;
  std::vector<double> ranges_m;
  ranges_m.reserve(kEnough + 1);
  for (std::size_t i = 0; i < scan.x_m.size(); i += step)
    ranges_m.push_back(std::hypot(
        scan.x_m[i] + (scan.origin_m[0] - from_m[0]), scan.y_m[i] + (scan.origin_m[1] - from_m[1]),
        scan.z_m[i] + (scan.origin_m[2] - from_m[2])));
  return ranges_m.empty() ? 0 : io::quantile(std::move(ranges_m), 0.5);
}

}  // namespace talus::import
