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

/** What changes from frame to frame, computed on the host in double. */
struct FrameContext
{
  int n_points;
  int has_times;
  /** Sensor poses at path_start_s + i / path_rate_hz; one pose where there is no motion to undo. */
  int n_poses;
  float path_start_s, path_rate_hz;
  /** (lambda_t * sin(theta / 2))^2 of eq. 4. */
  float pose_change2;
  /** The sensor's origin in the window frame; its z is also the reference of quantised heights. */
  float sensor_x_m, sensor_y_m, sensor_z_m;
  /** Column and row of storage where cell (0, 0) of the window lives. */
  int storage_x, storage_y;
  /** Whole cells that the window has moved by since the last frame, limited to +-n. */
  int moved_x, moved_y;
  /** 1 where cell (0, 0) of the window has an odd place in the map. */
  int odd_x, odd_y;
  WindowPose poses[kMaxPathPoses];
};

}  // namespace talus::kernels
