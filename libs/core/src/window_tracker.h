#pragma once
#include <talus/frame.h>
#include <talus/parameters.h>
#include "kernels/frame.h"

#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace talus
{
/** Where the window lies and how the sensors moved: the part of the map's state that lives on the
 * host, in double. */
struct WindowTracker
{
  struct Sensor
  {
    std::uint32_t number;  //!< Frame::sensor
    std::array<double, 3> z_axis;  //!< in its last frame, map frame
  };

  bool started = false;
  std::int64_t min_cell_x = 0, min_cell_y = 0;
  std::vector<Sensor> sensors;  //!< those that frames came from
  /** Of the last frame of any sensor; NaN: not known. */
  double last_stamp_s = std::numeric_limits<double>::quiet_NaN();

  /** Moves the window to the robot's base, which is the sensor where the frame does not tell where
   * the sensor is on the robot, and returns what the kernels need to know of the frame.
   * Throws std::invalid_argument if a pose is no rigid transform, or too far from the origin to
   * count cells (1e9 cells) or to tell heights apart (100 km), if the sensor is more than 1 km away
   * from the base, if the path does not ascend in time, and for more than 64 sensors. What it
   * leaves then is of no use. */
  kernels::FrameContext advance(const Frame& frame, const Parameters& p);

  /** Where the base is. Throws as advance(). */
  static Pose checked_base(const Frame& frame, const Parameters& p);
  /** The first cell of the window of a robot that is there. */
  static std::pair<std::int64_t, std::int64_t> min_cell(
      const Pose& T_map_base, const Parameters& p);
  /** Row or column where a cell, counted from the origin, is stored by a window of n x n. */
  static int storage(std::int64_t cell, int n) { return static_cast<int>(((cell % n) + n) % n); }

 private:
  std::array<double, 3>& z_axis_of(std::uint32_t sensor);
  float pause_until(double stamp_s);
};

}  // namespace talus
