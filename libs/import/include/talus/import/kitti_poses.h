#pragma once
#include <mrpt/poses/CPose3D.h>

#include <string>
#include <vector>

namespace talus::import
{
/** Whether the first line of a text has 12 numbers: a pose of KITTI's odometry. Throws
 * std::runtime_error as require_readable_file() does. */
bool is_kitti_poses(const std::string& path);

/** Of each scan the camera 0 in the frame that it has at the first one (x right, y down, z
 * forward): 12 numbers a line, three rows of [R t]. Throws std::runtime_error that names the file,
 * the line and what is wrong. */
std::vector<mrpt::poses::CPose3D> read_kitti_poses(const std::string& path);

/** The scanner in the frame of camera 0: the line `Tr:` of KITTI's calib.txt. Throws
 * std::runtime_error that names the file, what is wrong and what to do. */
mrpt::poses::CPose3D read_kitti_calibration(const std::string& path);

}  // namespace talus::import
