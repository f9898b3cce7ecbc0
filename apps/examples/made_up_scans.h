// What the examples map instead of a sensor's scans: a road along x with a block each ten metres.
#pragma once
#include <array>
#include <cmath>
#include <vector>

using Cloud = std::vector<std::array<float, 3>>;  // [m], frame of the sensor

constexpr double kSensorHeight_m = 0.7;

/** A turn of a scanner of 16 beams at (x_m, y_m) above the road, level and turned by yaw_rad.
 * Blocks of 0.5 x 0.5 x 0.4 m stand at x = 3, 13, 23 ... m, half a metre to the left of the middle
 * of the road. */
inline Cloud scan_of_road(double x_m, double y_m = 0, double yaw_rad = 0)
{
  constexpr double kFarthest_m = 12, kStep_m = 0.02;
  Cloud cloud;
  for (int beam = 0; beam < 16; beam++)
    for (int turn = 0; turn < 360; turn++)
    {
      const double up = -0.52 + 0.035 * beam, yaw = turn * 3.14159265 / 180;
      for (double range = 0.3; range < kFarthest_m; range += kStep_m)
      {
        const double dx = range * std::cos(up) * std::cos(yaw);
        const double dy = range * std::cos(up) * std::sin(yaw), dz = range * std::sin(up);
        const double x = x_m + std::cos(yaw_rad) * dx - std::sin(yaw_rad) * dy;
        const double y = y_m + std::sin(yaw_rad) * dx + std::cos(yaw_rad) * dy;
        const double z = kSensorHeight_m + dz, along = std::fmod(x + 1000, 10);
        const bool hits_block = z < 0.4 && along > 2.75 && along < 3.25 && y > 0.25 && y < 0.75;
        if (z > 0 && !hits_block) continue;
        cloud.push_back({static_cast<float>(dx), static_cast<float>(dy), static_cast<float>(dz)});
        break;
      }
    }
  return cloud;
}
