#pragma once
#include <talus/site/map_shift.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace talus::align
{
/** Where a map is tried: turned around a place of its own, so that turns and shifts are told apart.
 * All four are lengths: what a turn moves at `lever_m` from there. */
struct Pose
{
  double turn_rad = 0;  //!< around the origin, before all else
  Eigen::Vector2d middle{0, 0};  //!< once turned
  double lever_m = 1;
  Eigen::Vector4d v = Eigen::Vector4d::Zero();  //!< x, y, turn, z [m]

  /** Beside turn_rad. */
  double yaw_rad() const { return v[2] / lever_m; }
  Eigen::Vector2d turned(const Eigen::Vector2d& at_m) const
  {
    return turn_rad == 0 ? at_m : Eigen::Rotation2Dd(turn_rad) * at_m;
  }
  Eigen::Vector2d place(const Eigen::Vector2d& at_m) const
  {
    return Eigen::Rotation2Dd(yaw_rad()) * (turned(at_m) - middle) + middle + v.head<2>();
  }
  /** How the place changes with x, y and turn. */
  Eigen::Matrix<double, 2, 3> change(const Eigen::Vector2d& at_m) const
  {
    const Eigen::Vector2d arm = Eigen::Rotation2Dd(yaw_rad()) * (turned(at_m) - middle) / lever_m;
    Eigen::Matrix<double, 2, 3> j;
    j << 1, 0, -arm.y(), 0, 1, arm.x();
    return j;
  }
  site::MapShift shift() const
  {
    const Eigen::Vector2d t = place({0, 0});
    return {t.x(), t.y(), v[3], yaw_rad() + turn_rad};
  }
};

}  // namespace talus::align
