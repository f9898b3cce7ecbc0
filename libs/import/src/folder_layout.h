#pragma once
#include <talus/import/scan_source.h>

#include <string>
#include <vector>

namespace talus::import
{
/** The files of a folder of scans; those that are not there are empty. */
struct FolderLayout
{
  std::vector<std::string> scans;  //!< in the order of their names; one at least
  const Format* format = nullptr;  //!< of all of them
  std::string label;  //!< of the sensor: the name of the folder
  std::string times, calibration, poses;
  std::string kitti_360;  //!< its folder `calibration`
};

/** Looks into a folder, or beside a single file. KITTI's layouts: a sequence of the odometry data
 * (velodyne/, times.txt, calib.txt; poses.txt in it or poses/NN.txt beside sequences/), a drive of
 * the raw data (velodyne_points/), one of KITTI-360 (below data_3d_raw/). Throws std::runtime_error
 * that names the folder, what is wrong and what to do. */
FolderLayout find_layout(const Input& input);

}  // namespace talus::import
