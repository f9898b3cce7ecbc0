#pragma once
#include <talus/frame.h>

#include <cstddef>
#include <vector>

namespace talus::bench
{
/** One generated scan, sensor frame. */
struct Scan
{
  Pose T_map_sensor;
  std::vector<float> x_m, y_m, z_m;

  Frame frame() const;
};

/** What a spinning scanner sees on a short drive along x, in steps, among boxes on flat ground,
 * inside a round wall: every ray returns. Noise on the ranges; the same for the same arguments. */
std::vector<Scan> make_drive(std::size_t points, double radius_m, int scans, double apart_m);

/** The same along a road that repeats itself after `length_m`, driven in steps of `apart_m` until
 * both come out even: scan i % size() is what is seen at i * apart_m along x. The wall goes with
 * the sensor. radius_m <= length_m / 2. */
std::vector<Scan> make_road(std::size_t points, double radius_m, double length_m, double apart_m);

}  // namespace talus::bench
