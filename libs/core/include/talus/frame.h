#pragma once
#include <talus/channels.h>

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
  /** r00 r01 r02 tx r10 ... tz; the identity at first. */
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  /** x of the shift t [m]. */
  double x() const { return m[3]; }
  /** y of the shift t [m]. */
  double y() const { return m[7]; }
  /** z of the shift t [m]. */
  double z() const { return m[11]; }
};

constexpr std::size_t kMaxSensors = 64;  //!< max sensors of one map

/** A pose valid at a time [s], relative to the stamp of its frame. */
struct TimedPose
{
  double time_s = 0;  //!< time relative to the stamp of the frame [s]; it may be negative
  Pose T_map_sensor;  //!< pose of the sensor in the map frame at that time
};

/** Memory for the points of a scan, see ElevationMapper::point_arrays(). */
struct PointArrays
{
  /** The coordinates of each point in the sensor frame [m], and Frame::time_s. */
  float *x_m, *y_m, *z_m, *time_s;
};

/** One scan: points in the sensor frame. The caller keeps them until update(), or finish(),
 * returns. InterleavedPoints makes frames of points whose x, y, z are stored together. */
struct Frame
{
  double stamp_s = 0;  //!< time stamp, seconds since the epoch
  Pose T_map_sensor;  //!< pose of the sensor at stamp_s
  /** `size` coordinates each, sensor frame [m]; NaN and infinities are counted and dropped. */
  const float* x_m = nullptr;
  const float* y_m = nullptr;  //!< see x_m
  const float* z_m = nullptr;  //!< see x_m
  std::size_t size = 0;  //!< number of points
  /** Pose of the sensor on the robot: T_map_base = T_map_sensor * inverse(T_base_sensor). The base
   * is on the ground. Without it the base is the sensor, and the ground under it is not known. */
  std::optional<Pose> T_base_sensor;
  std::uint32_t sensor = 0;  //!< which of several sensors; any number
  /** Optional time of each point [s] relative to stamp_s, for `path`; nullptr: unknown. */
  const float* time_s = nullptr;
  /** Optional poses of the sensor during the scan, two or more in ascending time (else the map
   * throws). Each point is transformed with the pose interpolated at its time (deskew); points
   * before or after the path take its first or last pose. */
  std::vector<TimedPose> path;
  /** Optional values of each point, `size` each, in the order of Parameters::channels; nullptr: the
   * frame has none of that channel. NaN, and what is beyond 2^24 from zero, counts for nothing. */
  std::array<const float*, kMaxChannels> channels{};
};

/** T_map_base of a frame, the middle of the window; see Frame::T_base_sensor. */
Pose pose_of_base(const Pose& T_map_sensor, const std::optional<Pose>& T_base_sensor);

}  // namespace talus
