#pragma once
#include "kernels/config.h"

namespace talus::kernels
{
/** Rigid transform, row-major 3x4, from the sensor frame to the window frame: x, y from the
 * window's lower corner, z as in the map frame [m]. */
struct WindowPose
{
  float m[12];
};

constexpr int kMaxPathPoses = 64;

/** The values of one frame that the host computes, in double. */
struct HostContext
{
  int n_points;
  int has_times;
  int n_poses;  //!< sensor poses at path_start_s + i / path_rate_hz; one pose without motion
  float path_start_s, path_rate_hz;
  float pose_change2;  //!< (lambda_t * sin(theta / 2))^2 of eq. 4.
  float sensor_x_m, sensor_y_m, sensor_z_map_m;
  /** Rings of the table of rays that this frame uses, up to the farthest corner of the window. */
  int rings;
  /** Sensor frame to base frame, row-major 3x4 [m]; the identity where the base is not known. */
  float T_base_sensor[12];
  /** Whether the base is known and at least 0.1 m below the sensor, so that it is on the ground. */
  int has_base;
  /** The base in the window frame, z as in the map frame; the sensor where it is not known. */
  float base_x_m, base_y_m, base_z_m;
  /** dz/dx and dz/dy of the base's xy plane in the map, limited to +-1. */
  float base_slope_x, base_slope_y;
  int storage_x, storage_y;  //!< column and row of storage where cell (0, 0) of the window lives
  /** Whole cells that the window has moved by since the last frame, limited to +-n. */
  int moved_x, moved_y;
  int odd_x, odd_y;  //!< 1 where cell (0, 0) of the window has an odd index in the map
  WindowPose poses[kMaxPathPoses];
};

/** The values of one frame, as rules get them: FollowPoses sets what depends on the map. */
struct FrameContext : HostContext
{
  /** The sensor's z above the map's datum, which is the reference of quantised heights, and the
   * height of that datum in the map frame. */
  float sensor_z_m, offset_m;
  float drove_through_m;  //!< height of what the robot drove through in the last frame
  /** Whether all cells were empty before: in the first frame, and in the first on another floor. */
  int starts_map;
};

struct Point
{
  float x_m, y_m, z_m;
};

/** The points of a frame in the sensor frame, one array for each coordinate. */
struct PointsIn
{
  const float* x_m;
  const float* y_m;
  const float* z_m;
  const float* time_s;  //!< read only where FrameContext::has_times

  TALUS_HD Point at(int point_i) const { return {x_m[point_i], y_m[point_i], z_m[point_i]}; }
};

}  // namespace talus::kernels
