#include "bag_topics.h"

#include <talus/text.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace talus::import
{
BagRole role_of(const BagTopic& topic)
{
  static const std::map<std::string, BagRole> kRoles = {
      {"sensor_msgs/msg/PointCloud2", BagRole::Cloud},
      {"livox_ros_driver2/msg/CustomMsg", BagRole::Cloud},
      {"livox_ros_driver/msg/CustomMsg", BagRole::Cloud},
      {"livox_interfaces/msg/CustomMsg", BagRole::Cloud},
      {"nav_msgs/msg/Path", BagRole::Path},
      {"tf2_msgs/msg/TFMessage", BagRole::Tf},
      {"nav_msgs/msg/Odometry", BagRole::Odometry},
      {"geometry_msgs/msg/PoseStamped", BagRole::Pose},
      {"geometry_msgs/msg/PoseWithCovarianceStamped", BagRole::Pose}};
  const auto known = kRoles.find(topic.type);
  if (known == kRoles.end() || topic.encoding != "cdr") return BagRole::None;
  const bool is_static = known->second == BagRole::Tf && ends_with(topic.name, "tf_static");
  return is_static ? BagRole::TfStatic : known->second;
}

namespace
{
bool is_in(const std::vector<std::string>& names, const std::string& name)
{
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string list_of(const std::vector<BagTopic>& topics)
{
  constexpr std::size_t kMaxLines = 40, kMaxText = 100;
  std::string list;
  for (std::size_t i = 0; i < std::min(topics.size(), kMaxLines); ++i)
  {
    const auto& topic = topics[i];
    list += (i == 0 ? " " : ", ") + topic.name.substr(0, kMaxText) + " " +
            topic.type.substr(0, kMaxText);
    if (topic.encoding != "cdr") list += " (serialized as '" + topic.encoding.substr(0, 24) + "')";
  }
  if (topics.size() > kMaxLines)
    list += ", and " + std::to_string(topics.size() - kMaxLines) + " more";
  return topics.empty() ? " It holds no topics at all." : " It holds:" + list;
}

/** How what a bag has instead of clouds becomes clouds; "": nobody knows. */
std::string advice_for(const std::vector<BagTopic>& topics)
{
  struct Advice
  {
    const char *type, *name, *text;
  };
  constexpr Advice kAdvice[] = {
      {"Packet", "",
       "has packets of a scanner: play the bag, let the driver of the scanner make "
       "PointCloud2 of them, and record these"},
      {"VelodyneScan", "",
       "has packets: velodyne_pointcloud makes PointCloud2 of them; record these"},
      {"UdpFrame", "",
       "has packets: the driver of the scanner makes PointCloud2 of them; record these"},
      {"sensor_msgs/msg/Image", "depth",
       "has depth images: point_cloud_xyz of depth_image_proc "
       "makes PointCloud2 of them; record these"},
      {"sensor_msgs/msg/LaserScan", "", "is of a scanner of one plane, which shows no ground"}};
  for (const Advice& advice : kAdvice)
    for (const auto& topic : topics)
      if (topic.type.find(advice.type) != std::string::npos &&
          topic.name.find(advice.name) != std::string::npos)
        return " " + topic.name.substr(0, 100) + " " + advice.text + ".";
  return "";
}
}  // namespace

std::vector<BagRole> roles_of(
    const std::vector<BagTopic>& topics, const std::vector<std::string>& wanted,
    const std::string& path)
{
  std::vector<BagRole> roles;
  roles.reserve(topics.size());
  std::transform(topics.begin(), topics.end(), std::back_inserter(roles), role_of);

  std::vector<bool> is_named;
  is_named.reserve(topics.size());
  for (const auto& topic : topics) is_named.push_back(is_in(wanted, topic.name));
  for (const auto& name : wanted)
  {
    bool is_read = false;
    for (std::size_t i = 0; i < topics.size(); ++i)
      is_read = is_read || (topics[i].name == name && roles[i] != BagRole::None);
    if (!is_read)
      throw std::runtime_error(
          path + ": has no topic " + name + " that is read (--topic)." + list_of(topics));
  }
  bool names_clouds = false, has_clouds = false;
  for (std::size_t i = 0; i < topics.size(); ++i)
    names_clouds = names_clouds || (is_named[i] && roles[i] == BagRole::Cloud);
  for (std::size_t i = 0; i < topics.size(); ++i)
  {
    if (names_clouds && roles[i] == BagRole::Cloud && !is_named[i]) roles[i] = BagRole::None;
    has_clouds = has_clouds || roles[i] == BagRole::Cloud;
  }
  if (!has_clouds)
    throw std::runtime_error(
        path + ": has no topic with sensor_msgs/msg/PointCloud2 in CDR." + advice_for(topics) +
        list_of(topics));
  return roles;
}

std::string too_long_names(std::size_t bytes, std::size_t topics)
{
  constexpr std::size_t kMaxBytes = std::size_t{1} << 22, kMaxTopics = 10000;
  if (topics <= kMaxTopics && bytes <= kMaxBytes) return "";
  return "no bag has " + std::to_string(topics) + " topics with " + std::to_string(bytes) +
         " bytes of names";
}

}  // namespace talus::import
