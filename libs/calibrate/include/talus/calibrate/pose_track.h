#pragma once
#include <talus/io/trajectory.h>

#include <Eigen/Dense>

#include <vector>

namespace talus::calibrate
{
/** T_map_base at a time and its velocity. The map's origin is moved to the first pose of the track,
 * so that large coordinates cost no digits. */
struct TrackPose
{
  Eigen::Matrix3d R, dR;  //!< dR [1/s]
  Eigen::Vector3d t_m, dt_mps;
};

/** A trajectory that can be differentiated: cubic Hermite curves through the positions and the
 * quaternions, so that the velocity has no jumps at the poses. */
class PoseTrack
{
 public:
  PoseTrack() = default;
  /** Poses farther apart than `max_gap_s` are not connected. */
  PoseTrack(const io::Trajectory& trajectory, double max_gap_s);

  /** Whether there are poses around this time. */
  bool covers(double time_s) const;
  /** Beyond the poses next to it the curve goes straight on. There must be two or more poses. */
  TrackPose at(double time_s) const;

  std::size_t size() const { return knots_.size(); }
  double first_s() const { return knots_.front().time_s; }
  double last_s() const { return knots_.back().time_s; }
  /** Time of the first pose after this time; infinite after the last. */
  double next_s(double time_s) const;
  /** Length of the path [m], and the largest turn between the first pose and any other [rad]. */
  double length_m() const;
  double turn_rad() const;

 private:
  struct Knot
  {
    double time_s;
    Eigen::Matrix<double, 7, 1> value, slope;  //!< position [m], quaternion (x y z w); by time
  };
  Eigen::Matrix<double, 7, 1> value_at(double time_s) const;
  Eigen::Matrix<double, 7, 1> chord(std::size_t from, std::size_t to) const;
  std::vector<Knot>::const_iterator knot_after(double time_s) const;
  std::size_t segment_of(double time_s) const;

  std::vector<Knot> knots_;
  double max_gap_s_ = 0;
};

}  // namespace talus::calibrate
