#pragma once
#include <mrpt/poses/CPose3D.h>

#include <cstddef>
#include <string>
#include <vector>

namespace talus::import
{
/** Poses a line each, as KITTI's data sets and many SLAM programs write them. */
struct KittiPoses
{
  /** In the order of the file; in the frame that it has. */
  std::vector<mrpt::poses::CPose3D> poses;
  /** The number of the scan that each belongs to; empty: the first belongs to scan 0, and so on. */
  std::vector<std::size_t> frames;
};

/** Whether the first line of a text has 12 numbers, a pose of KITTI's odometry, or 13: KITTI-360's.
 * Throws std::runtime_error as require_readable_file() does. */
bool is_kitti_poses(const std::string& path);

/** Three rows of [R t], 12 numbers a line; in KITTI-360 the number of the frame comes before them.
 * Of camera 0 in the frame that it has at the first one (x right, y down, z forward), of
 * KITTI-360's GPS unit in a frame of the world, or of what the program that wrote them means.
 * Throws std::runtime_error that names the file, the line and what is wrong. */
KittiPoses read_kitti_poses(const std::string& path);

/** The scanner in the frame of camera 0: the line `Tr:` of KITTI's calib.txt. Throws
 * std::runtime_error that names the file, what is wrong and what to do. */
mrpt::poses::CPose3D read_kitti_calibration(const std::string& path);

/** The scanner in the frame of KITTI-360's poses: calib_cam_to_pose.txt and calib_cam_to_velo.txt
 * in its folder `calibration`. Throws as read_kitti_calibration(). */
mrpt::poses::CPose3D read_kitti_360_calibration(const std::string& folder);

}  // namespace talus::import
