#pragma once
#include <mrpt/math/TPose3DQuat.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "point_fields.h"

namespace talus::import
{
// Of messages of ROS 2 what is needed of them. Each throws CdrError where the message is
// damaged.

inline double seconds(std::int64_t time_ns) { return static_cast<double>(time_ns) * 1e-9; }

struct MessageHeader
{
  std::int64_t stamp_ns = 0;  //!< since the epoch; 0: not set
  std::string frame;
};

/** Of tf2_msgs/msg/TFMessage one link, and of a pose the map, and the base in it. */
struct FrameTransform
{
  MessageHeader parent;
  std::string child;  //!< empty: a message that does not name it
  std::optional<mrpt::math::TPose3DQuat> T_parent_child;  //!< none: not finite, or no rotation
};

/** sensor_msgs/msg/PointCloud2, or Livox's CustomMsg as one; its data lie in the message. */
struct CloudMessage
{
  struct Field : PointField
  {
    std::uint32_t offset = 0;
  };

  MessageHeader header;
  std::uint32_t height = 0, width = 0, point_step = 0, row_step = 0;
  std::vector<Field> fields;
  bool is_big_endian = false;
  std::string_view data;
};

/** Of any message that begins with one. */
MessageHeader read_header(std::string_view message);

/** The links one after the other: a message that unpacks to millions of them holds one in memory.
 */
void for_each_link(std::string_view message, const std::function<void(FrameTransform)>& take);
FrameTransform read_odometry(std::string_view message);

/** PoseStamped and PoseWithCovarianceStamped. */
FrameTransform read_pose(std::string_view message);

/** nav_msgs/msg/Path: its poses, as for_each_link(). */
void for_each_pose(std::string_view message, const std::function<void(FrameTransform)>& take);

/** `type`: of the message. */
CloudMessage read_cloud(std::string_view message, const std::string& type = "");

/** Whether its points are where scanners see them in the other byte order than it says, and few in
 * this one. `place` and `most_points` as below. */
bool is_of_other_order(
    const CloudMessage& cloud, const std::string& place, std::uint64_t most_points);

/** The points of a cloud, no more than may be; those that are not finite are left out. Throws
 * CdrError, and as PointCollector does. */
void collect_points(
    const CloudMessage& cloud, const std::string& place, ScanFile& out,
    std::uint64_t most_points = std::numeric_limits<std::uint64_t>::max());

}  // namespace talus::import
