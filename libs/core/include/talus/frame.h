#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace talus
{
/** Rigid transform, row-major 3x4 [R|t]: p_parent = R * p_child + t, metres. */
struct Pose
{
  /** r00 r01 r02 tx r10 ... tz; no rotation and no shift at first. */
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  /** Of the shift t [m]. */
  double x() const { return m[3]; }
  /** Of the shift t [m]. */
  double y() const { return m[7]; }
  /** Of the shift t [m]. */
  double z() const { return m[11]; }
};

/** Most sensors that one map tells apart. */
constexpr std::size_t kMostSensors = 64;

/** A pose valid at a time [s], relative to the stamp of its frame. */
struct TimedPose
{
  /** [s] relative to the stamp of the frame, may be negative. */
  double time_s = 0;
  /** Pose of the sensor in the map frame then. */
  Pose T_map_sensor;
};

/** Room for the coordinates of a scan, see ElevationMapper::point_arrays(). */
struct PointArrays
{
  /** Of each point: coordinates in the sensor frame [m], and Frame::time_s. */
  float *x_m, *y_m, *z_m, *time_s;
};

/** One scan: points in the sensor frame. Views only: the caller keeps the memory of the points
 * until update(), or finish(), returns. Of points whose x, y, z lie side by side InterleavedPoints
 * makes a frame. */
struct Frame
{
  double stamp_s = 0;  //!< time stamp, seconds since the epoch
  Pose T_map_sensor;  //!< pose of the sensor at stamp_s
  /** `size` coordinates each, sensor frame [m]; NaN and infinities are counted and dropped. */
  const float* x_m = nullptr;
  /** As x_m. */
  const float* y_m = nullptr;
  /** As x_m. */
  const float* z_m = nullptr;
  /** Number of points. */
  std::size_t size = 0;
  /** Where the sensor is on the robot, so that T_map_base = T_map_sensor * inverse(T_base_sensor).
   * The base is on the ground that the robot stands on. Not given: the base is the sensor, and
   * nothing is known of what the robot stands on. */
  std::optional<Pose> T_base_sensor;
  std::uint32_t sensor = 0;  //!< which of several sensors: any number, each its own
  /** Optional time of each point [s] relative to stamp_s; nullptr when unknown. Used with `path`
   * only. */
  const float* time_s = nullptr;
  /** Optional poses of the sensor during the scan, two or more, which ascend in time (else the map
   * throws): each point is then transformed with the pose interpolated at its time (deskew); points
   * outside take the first or last pose. */
  std::vector<TimedPose> path;
};

/** T_map_base of a frame, see Frame::T_base_sensor: what the window lies around. */
Pose pose_of_base(const Pose& T_map_sensor, const std::optional<Pose>& T_base_sensor);

}  // namespace talus
