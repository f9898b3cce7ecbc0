#pragma once
#include <talus/frame.h>
#include <talus/parameters.h>
#include "kernels/frame.h"

#include <array>
#include <cstdint>

namespace talus
{
/** Where the window lies and how the sensor moved: the part of the map's state that lives on the
 * host, in double. */
struct WindowTracker
{
  bool started = false;
  std::int64_t min_cell_x = 0, min_cell_y = 0;
  std::array<double, 3> last_z_axis{0, 0, 1};  //!< of the sensor, map frame

  /** Moves the window to the frame's sensor and returns what the kernels need to know of the frame.
   * Throws std::invalid_argument if a pose is no rigid transform, or too far from the origin to
   * count cells (1e9 cells) or to tell heights apart (100 km), or if the path does not ascend in
   * time. */
  kernels::FrameContext advance(const Frame& frame, const Parameters& p);

  /** Row or column where a cell, counted from the origin, is stored by a window of n x n. */
  static int storage(std::int64_t cell, int n) { return static_cast<int>(((cell % n) + n) % n); }
};

}  // namespace talus
