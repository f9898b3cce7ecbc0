#pragma once
#include <cstddef>
#include <optional>

#include "base_points.h"

namespace talus::hints
{
/** Looks for poses that climb and stay level, as those of a localisation without pitch do: the path
 * rises, the base does not lean back, and the ground that is seen is level, too, since the sensor
 * leans with the robot. A robot that keeps its body level on a slope sees the slope. */
class LevelWatch
{
 public:
  /** Each pose, in the order of time. */
  void add(const Pose& T_map_base);
  /** The normal of the ground that is seen with the pose that was added last, frame of the map. */
  void add_ground(const Vec3& normal_map) { normal_ = normal_map; }

  /** How many pieces of the path were looked at. */
  std::size_t pieces() const { return pieces_; }
  /** Slope of the path, root mean square [rad]. */
  double path_slope_rad() const;
  /** What noise of the heights alone would make of level ground [rad]. */
  double noise_slope_rad() const;
  /** Share of the slope of the path that the poses lean by; 1 where all is well. */
  double pose_share() const;
  /** Share of the slope of the path that the ground that is seen leans by. */
  double ground_share() const;
  /** z of the base from the lowest to the highest [m]. */
  double climb_m() const { return highest_m_ - lowest_m_; }
  /** The most that the base leaned [rad]. */
  double most_lean_rad() const { return most_lean_rad_; }

 private:
  void note_height(double z_m);
  void end_piece(const Pose& T_map_base);

  std::optional<Pose> begin_;
  std::optional<Vec3> normal_;
  std::size_t pieces_ = 0, heights_ = 0, bends_ = 0;
  double slopes_ = 0, leans_ = 0, grounds_ = 0;  //!< sums of products with the slope of the path
  double last_m_ = 0, step_m_ = 0, bend_squares_ = 0;
  double lowest_m_ = 0, highest_m_ = 0, most_lean_rad_ = 0;
};

}  // namespace talus::hints
