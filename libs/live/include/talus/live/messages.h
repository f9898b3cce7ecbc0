#pragma once
#include <mrpt/poses/CPose3D.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/** Messages of ROS 2, serialized. */
namespace talus::live
{
/** Whence a message is, and when. */
struct Header
{
  double stamp_s = 0;  //!< since the epoch
  std::string frame;  //!< by its name in TF
};

/** geometry_msgs/TransformStamped: a frame in that of the header. */
struct Link
{
  Header header;  //!< of the parent
  std::string child;  //!< the name of the frame
  mrpt::poses::CPose3D T_parent_child;  //!< where it is
};

/** Points of a cloud; the vectors are empty, or have a value a point. */
struct CloudPoints
{
  /** In the frame of the header [m]. */
  std::vector<float> x_m, y_m, z_m;
  std::vector<float> intensity;  //!< in whatever unit
  std::vector<float> time_s;  //!< after the stamp of the header
};

/** Cells of nav_msgs/OccupancyGrid: 0 free, 100 occupied, -1 unknown. */
struct Grid
{
  int cells_x = 0, cells_y = 0;  //!< along each axis
  double resolution_m = 0;  //!< side of a cell
  double min_x_m = 0, min_y_m = 0;  //!< outer corner of the first cell
  std::vector<std::int8_t> cells;  //!< row by row, the southern one first
};

/** tf2_msgs/TFMessage. */
std::string tf_message(const std::vector<Link>& links);
/** nav_msgs/Odometry, without velocities and covariances. */
std::string odometry_message(const Link& pose);
/** sensor_msgs/PointCloud2 with the fields x, y, z and those that there are of intensity and
 * time. */
std::string cloud_message(const Header& header, const CloudPoints& points);
/** nav_msgs/OccupancyGrid. */
std::string grid_message(const Header& header, const Grid& grid);
/** map_msgs/OccupancyGridUpdate: the cells of `grid`, whose first is cell (x, y) of the map. */
std::string grid_update_message(const Header& header, const Grid& grid, int x, int y);
/** nav_msgs/Path: of the base, with the times of the poses. */
std::string path_message(
    const Header& header, const std::vector<std::pair<double, mrpt::poses::CPose3D>>& poses);

}  // namespace talus::live
