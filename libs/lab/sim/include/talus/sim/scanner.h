#pragma once
#include <talus/sim/world.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace talus::sim
{
/** A sensor that measures ranges along fixed directions: a spinning LiDAR or a depth camera. */
struct Scanner
{
  std::string name, description;
  std::vector<double> elevations_rad;  //!< of the beams, or of the rows of a camera's image
  int columns = 0;  //!< directions around the vertical axis a sweep, or columns of a camera's image
  bool camera = false;  //!< looks forward through a pinhole; all pixels at the same time
  double half_width_tan = 0;  //!< of a camera: tangent of half its horizontal field of view
  double rate_hz = 10;
  double min_range_m = 0.2, max_range_m = 100;
  double noise_m = 0.015;  //!< standard deviation of a range
  double noise_per_m = 0;  //!< its growth with the range
  double noise_per_m2 = 0;  //!< its growth with the square of the range
  double dropout = 0;  //!< share of the returns that get lost, [0, 1]

  /** When a column is measured after the start of the sweep [s]. */
  double column_time_s(int column) const;
};

/** All known scanners. */
const std::vector<Scanner>& scanners();
/** The scanner of that name (case ignored), or nullptr. */
const Scanner* find_scanner(const std::string& name);

/** The points of one sweep, sensor frame at the stamp, in the order measured. */
struct Scan
{
  std::vector<float> x_m, y_m, z_m;
  std::vector<float> intensity;  //!< [0, 1]
  std::vector<std::uint16_t> ring;  //!< index of the beam
  std::vector<float> time_s;  //!< since the start of the sweep; empty without motion distortion
  std::size_t size() const { return x_m.size(); }
};

/** When and from where a sweep is taken. */
struct Sweep
{
  double time_s = 0;  //!< of its first column, since the start of the drive
  /** Of the scanner's columns, those from the first up to, without, the end. */
  int first_column = 0, end_column = std::numeric_limits<int>::max();
  std::function<Pose(double time_s)> T_map_sensor;
  /** False: all points are taken from the pose at the start, at that time. True: each from where
   * the sensor is by then, of a world that goes on moving. */
  bool motion_distortion = false;
  std::vector<Shape> body;  //!< of the robot, in the frame of the sensor
  std::uint64_t seed = 1;  //!< the same seed, the same noise; take another one for each sweep
};
Scan take_scan(const World& world, const Scanner& scanner, const Sweep& sweep);

}  // namespace talus::sim
