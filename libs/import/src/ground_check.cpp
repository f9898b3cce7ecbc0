#include "placed_scans.h"

#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
constexpr double kLayer_m = 0.05, kLowest_m = -4;
constexpr std::size_t kLayers = 160;  // up to 4 m
struct Layer
{
  std::size_t points = 0;
  double sum_m = 0;  //!< of their heights
};
using Layers = std::array<Layer, kLayers>;

/** Points near the sensor, and below it, in layers of their heights in the base. */
Layers layers_of(const ImportedScan& scan)
{
  constexpr double kNearest_m = 1, kFarthest_m = 12;
  const auto& T = scan.T_base_sensor;
  const auto& R = T.getRotationMatrix();
  Layers layers{};
  for (std::size_t i = 0; i < scan.x_m.size(); ++i)
  {
    const double x = scan.x_m[i], y = scan.y_m[i], z = scan.z_m[i];
    const double range_m = std::hypot(x, y);
    if (!(range_m >= kNearest_m && range_m <= kFarthest_m)) continue;
    const double up_m = R(2, 0) * x + R(2, 1) * y + R(2, 2) * z;
    const double height_m = up_m + T.z(), layer = (height_m - kLowest_m) / kLayer_m;
    if (!(up_m < 0 && layer >= 0 && layer < kLayers)) continue;
    auto& [points, sum_m] = layers[static_cast<std::size_t>(layer)];
    ++points;
    sum_m += height_m;
  }
  return layers;
}

/** The height at which most points lie, where that is level ground and no accident. */
std::optional<double> ground_of(const ImportedScan& scan)
{
  constexpr std::size_t kMinCount = 100;
  constexpr double kShare = 0.3;
  const Layers layers = layers_of(scan);
  std::size_t all = 0;
  for (const Layer& layer : layers) all += layer.points;
  Layer most;  // of three layers that follow each other: ground is rough
  for (std::size_t i = 1; i + 1 < kLayers; ++i)
  {
    const Layer &below = layers[i - 1], &at = layers[i], &above = layers[i + 1];
    const std::size_t points = below.points + at.points + above.points;
    if (points > most.points) most = {points, below.sum_m + at.sum_m + above.sum_m};
  }
  const auto points = static_cast<double>(most.points);
  if (most.points < kMinCount || points < kShare * static_cast<double>(all)) return {};
  return most.sum_m / points;
}

/** The height of most scans; nothing where they do not agree. */
std::optional<double> common_height_m(const std::vector<double>& ground_m)
{
  constexpr double kSame_m = 0.1, kMax = 0.7;
  if (ground_m.empty()) return {};
  const double height_m = io::quantile(ground_m, 0.5);
  const auto same = std::count_if(
      ground_m.begin(), ground_m.end(),
      [=](double other_m) { return std::abs(other_m - height_m) < kSame_m; });
  const bool is_common = static_cast<double>(same) >= kMax * static_cast<double>(ground_m.size());
  return is_common ? std::optional<double>(height_m) : std::nullopt;
}

std::string mounting_text(const CPose3D& T, double z_m)
{
  const auto degrees = [](double radians) { return number_text(radians * 180 / M_PI + 0.0, 6); };
  return number_text(T.x(), 6) + "," + number_text(T.y(), 6) + "," + fixed_text(z_m, 2) + "," +
         degrees(T.yaw()) + "," + degrees(T.pitch()) + "," + degrees(T.roll());
}
}  // namespace

void GroundCheck::look_at(const ImportedScan& scan)
{
  constexpr std::size_t kFirst = 20, kEach = 10, kEnough = 500;
  Sensor& sensor = sensors_[scan.sensor_label];
  const std::size_t number = sensor.scans++;
  if (number == 0) sensor.T_base_sensor = scan.T_base_sensor;
  if ((number >= kFirst && number % kEach != 0) || sensor.ground_m.size() >= kEnough) return;
  if (const auto ground_m = ground_of(scan)) sensor.ground_m.push_back(*ground_m);
}

std::vector<std::string> GroundCheck::remarks() const
{
  constexpr double kWrong_m = 0.1;  // roads are as flat as that
  std::vector<std::string> all;
  for (const auto& [label, sensor] : sensors_)
  {
    const auto ground_m = common_height_m(sensor.ground_m);
    if (!ground_m || std::abs(*ground_m) < kWrong_m) continue;
    const double mounted_m = sensor.T_base_sensor.z(), seen_m = mounted_m - *ground_m;
    const std::string seen = fixed_text(seen_m, 2) + " m below ";
    all.push_back(
        (mounted_m == 0
             ? "the ground is seen " + seen + label
             : "the ground contradicts the mounting of " + label + ": it should be " +
                   fixed_text(mounted_m, 2) + " m below the sensor and is seen " + seen + "it") +
        " (--mount " + label + "=" + mounting_text(sensor.T_base_sensor, seen_m) + ")");
  }
  return all;
}

}  // namespace talus::import
