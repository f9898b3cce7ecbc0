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

/** How a robot stops, and where it is in front of its base. */
struct Stopping
{
  double reaction_s = 0.4;  //!< from the sweep that shows why to the brakes
  double deceleration_mps2 = 1.0;  //!< > 0
  double front_m = 0.3;  //!< of its body, before the base

  /** Distance that it needs from a speed [m]. */
  double distance_m(double speed_mps) const
  {
    return speed_mps * reaction_s + speed_mps * speed_mps / (2 * deceleration_mps2);
  }
};

/** A hole in level ground is found when a ray of a sweep passes kFound_m or more below its near
 * edge, straight ahead. */
constexpr double kFound_m = 0.05;

/** The minimum width [m], along the path, of a hole that a robot which drives straight at it finds
 * in time to stop before it, however the sweeps fall; infinite where no ray meets the ground far
 * enough ahead. `T_base_sensor`: the base is on the ground. */
double narrowest_hole_m(
    const Scanner& scanner, const Pose& T_base_sensor, double speed_mps, const Stopping& stopping);

/** The maximum speed [m/s], to a hundredth and up to 20, at which it finds each hole of this width
 * in time; 0: at none. */
double fastest_before_hole_mps(
    const Scanner& scanner, const Pose& T_base_sensor, double width_m, const Stopping& stopping);

/** Where the ray straight ahead that looks down most steeply meets level ground, from the base
 * [m]; infinite where none does. */
double nearest_ground_m(const Scanner& scanner, const Pose& T_base_sensor);

}  // namespace talus::sim
