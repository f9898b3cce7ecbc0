#pragma once
#include <talus/frame.h>
#include <talus/parameters.h>
#include "kernels/frame.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace talus
{
constexpr double kMaxHeight_m = 1e5;  // floats are 8 mm apart there

/** The position of the window and the motion of the sensors: the map's state on the host. */
struct WindowTracker
{
  struct Sensor
  {
    std::uint64_t number;  //!< Frame::sensor; as wide as saved maps have it
    std::array<double, 3> z_axis;  //!< in its last frame, map frame
  };

  bool started = false;
  std::int64_t min_cell_x = 0, min_cell_y = 0;
  std::vector<Sensor> sensors;  //!< all that sent frames

  /** Moves the window to the robot's base, or to the sensor where the base is not known, and
   * returns the values that the kernels need. Throws std::invalid_argument if a pose is no rigid
   * transform, or too far from the origin to count cells (1e9 cells) or to resolve heights (100
   * km), if the sensor is more than 1 km from the base, if the path does not ascend in time, and
   * for more than 64 sensors. Then the tracker is of no use. */
  kernels::FrameContext advance(const Frame& frame, const Parameters& p);

  /** The values of a frame whose points are looked up in the window as it is. Throws as advance()
   * does, but the tracker stays as it was. */
  kernels::FrameContext look_up(const Frame& frame, const Parameters& p) const;

  /** The pose of the base. Throws as advance() does. */
  static Pose checked_base(const Frame& frame, const Parameters& p);
  static std::pair<std::int64_t, std::int64_t> min_cell(
      const Pose& T_map_base, const Parameters& p);
  /** Row or column where a window of n x n stores a cell, counted from the origin. */
  static int storage(std::int64_t cell, int n) { return static_cast<int>(((cell % n) + n) % n); }

 private:
  std::array<double, 3>& z_axis_of(std::uint32_t sensor);
};

}  // namespace talus
