#pragma once
#include <cmath>

namespace talus::site
{
/** How a map is moved into the frame of another: turned about the z axis of its frame, then
 * shifted. */
struct MapShift
{
  /** [m], in the frame that it comes into. */
  double x_m = 0, y_m = 0, z_m = 0;
  /** Counter-clockwise. */
  double yaw_rad = 0;

  /** Whether its cells move; otherwise heights alone change. */
  bool moves_cells() const { return x_m != 0 || y_m != 0 || yaw_rad != 0; }
  /** Whether it does anything. */
  bool moves() const { return moves_cells() || z_m != 0; }
  /** Where a point of the map comes to. */
  void apply(double& at_x_m, double& at_y_m) const
  {
    const double c = std::cos(yaw_rad), s = std::sin(yaw_rad), x = at_x_m;
    at_x_m = c * x - s * at_y_m + x_m;
    at_y_m = s * x + c * at_y_m + y_m;
  }
  /** Which point of the map comes there. */
  void undo(double& at_x_m, double& at_y_m) const
  {
    const double c = std::cos(yaw_rad), s = std::sin(yaw_rad), x = at_x_m - x_m, y = at_y_m - y_m;
    at_x_m = c * x + s * y;
    at_y_m = c * y - s * x;
  }
};

}  // namespace talus::site
