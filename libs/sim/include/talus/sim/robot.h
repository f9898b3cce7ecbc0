#pragma once
#include <talus/sim/world.h>

#include <vector>

namespace talus::sim
{
/** The way of a robot over the ground. */
class RobotPath
{
 public:
  /** Keeps a reference to `ground`. */
  RobotPath(const RobotSetup& setup, const Ground& ground);

  /** Length of the curve seen from above [m]. */
  double length_m() const { return points_.back().distance_m; }
  /** Of the drive [s]: what its setup says, else as long as the way takes. */
  double duration_s() const;
  /** Distance driven by a time [m]. */
  double distance_m(double time_s) const;

  /** Pose of the base at a time since the start: its origin on the ground, its axes as four wheels
   * stand on the ground below them. */
  Pose T_map_base(double time_s) const;

  /** Smallest horizontal distance from a place to the curve [m]. */
  double distance_to_m(double x_m, double y_m) const;

  /** Corners of the curve's bounding box: least and greatest x and y; z is 0. */
  Bounds bounds() const;

 private:
  struct Point
  {
    double distance_m, x_m, y_m;
  };
  std::vector<Point> points_;  //!< the curve as short straight pieces
  RobotSetup setup_;
  const Ground& ground_;
};

}  // namespace talus::sim
