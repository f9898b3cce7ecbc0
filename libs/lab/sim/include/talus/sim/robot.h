#pragma once
#include <talus/sim/world.h>

#include <vector>

namespace talus::sim
{
/** The path of a robot over the ground, and over decks: of several floors it is on the highest that
 * is no more than a step above the one from which it comes. */
class RobotPath
{
 public:
  /** The path of the world's robot. Keeps a reference to the world. */
  explicit RobotPath(const World& world);

  /** Length of the curve seen from above [m]. */
  double length_m() const { return points_.back().distance_m; }
  /** Of the drive [s]: what its setup says, else as long as the path takes. */
  double duration_s() const;
  /** How long the path takes, lifts included [s]. */
  double path_s() const;
  /** Distance driven by a time [m]. */
  double distance_m(double time_s) const;

  /** Pose of the base at a time since the start: its origin on the floor, its axes as four wheels
   * stand on the floor below them. Where a lift has left it above or below all floors, it stays at
   * that height until it comes to one. */
  Pose T_map_base(double time_s) const;

  /** Smallest horizontal distance from (x, y) to the curve [m]. */
  double distance_to_m(double x_m, double y_m) const;

  /** Corners of the curve's bounding box: minimum and maximum x and y; z is 0. */
  Bounds bounds() const;

 private:
  struct Point
  {
    double distance_m, x_m, y_m;
  };
  /** What the robot drives from one lift to the next. */
  struct Leg
  {
    std::size_t first = 0;  //!< the last point that it had passed when the leg began
    std::vector<double> floor_m;  //!< below the middle of the robot at that point and those after
    double lands_m = 0;  //!< distance driven from which on there is a floor below it
  };
  void follow_floors();
  Leg leg(std::size_t first, double start_s, double floor_m) const;
  std::size_t point_before(double distance_m) const;
  double time_at_s(double distance_m, std::size_t lifts) const;
  Pose stand(double time_s, std::size_t leg) const;
  double wheel_m(double x_m, double y_m, double time_s, std::size_t leg) const;

  const World& world_;
  std::vector<Point> points_;  //!< the curve as short straight pieces
  std::vector<Leg>
      legs_;  //!< before the first lift and after each; none where all is on the ground
};

}  // namespace talus::sim
