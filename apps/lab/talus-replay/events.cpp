#include "events.h"

#include "../../common/log_name.h"

#include <talus/io/rawlog_reader.h>
#include <talus/live/messages.h>
#include <talus/mrpt/observation_points.h>
#include <talus/text.h>

#include "bag_reader.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <deque>
#include <map>
#include <stdexcept>
#include <utility>

namespace talus::app
{
namespace
{
class BagEvents : public Events
{
 public:
  explicit BagEvents(const std::string& path) : reader_({path}, false)
  {
    std::vector<bool> wanted;
    for (const auto& topic : reader_.topics()) wanted.push_back(topic.encoding == "cdr");
    reader_.start(std::move(wanted));
  }
  bool next(Event& event) override
  {
    import::BagMessage message;
    if (!reader_.next(message)) return false;
    const auto& topic = reader_.topics()[message.topic];
    event = {
        static_cast<double>(message.log_time_ns) * 1e-9, topic.name, topic.type,
        ends_with(topic.name, "tf_static"), std::string(reader_.payload())};
    return true;
  }

 private:
  import::BagReader reader_;
};

constexpr const char* kTf = "tf2_msgs/msg/TFMessage";
constexpr const char* kMap = "map";
constexpr const char* kOdom = "odom";
constexpr const char* kBase = "base_link";

/** A name that ROS allows for a topic, and without its slash for a frame. */
std::string topic_of(const std::string& label)
{
  std::string name = label.empty() || label[0] != '/' ? "/" + label : label;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '/') c = '_';
  return name == "/" ? "/points" : name;
}

io::Trajectory poses_of(const std::string& path, const std::string& given)
{
  auto poses = poses_of_log(path, given);
  if (poses.empty())
    throw std::runtime_error(
        path + ": has no poses of the robot. Pass --trajectory FILE, or put them into " +
        trajectory_beside(path));
  return poses;
}

class RawlogEvents : public Events
{
 public:
  RawlogEvents(const std::string& path, const RawlogTopics& options)
      : reader_(path),
        poses_(poses_of(path, options.trajectory)),
        as_odometry_(options.as_odometry),
        slam_every_s_(options.slam_every_s)
  {
    if (!options.slam.empty()) slam_ = io::Trajectory::load(options.slam);
    points_.channel_names = {"intensity"};
  }

  bool next(Event& event) override
  {
    if (path_.time_s > 0)
    {
      event = std::exchange(path_, {});
      return true;
    }
    if (due_.empty()) read_scan();
    if (due_.empty()) return next_pose(event);
    const auto& entries = poses_.entries();
    if (pose_ < entries.size() && entries[pose_].time_s <= due_.front().time_s)
      return next_pose(event);
    event = std::move(due_.front());
    due_.pop_front();
    return true;
  }

 private:
  bool next_pose(Event& event)
  {
    if (pose_ == poses_.entries().size()) return false;
    const auto& entry = poses_.entries()[pose_++];
    live::Link link{{entry.time_s, kMap}, kBase, entry.T_map_base};
    if (!slam_.empty())
    {
      correct(entry);
      const live::Link odom{link.header, kOdom, T_map_odom_};
      link.header.frame = kOdom;
      event = {entry.time_s, "/tf", kTf, false, live::tf_message({odom, link})};
      return true;
    }
    event =
        as_odometry_
            ? Event{entry.time_s, "/odom", "nav_msgs/msg/Odometry", false, live::odometry_message(link)}
            : Event{entry.time_s, "/tf", kTf, false, live::tf_message({link})};
    return true;
  }
  void correct(const io::Trajectory::Entry& odometry);
  void read_scan();

  io::RawlogReader reader_;
  io::Trajectory poses_, slam_;
  bool as_odometry_;
  double slam_every_s_, corrected_s_ = 0;  //!< when it was last
  mrpt::poses::CPose3D T_map_odom_;
  Event path_;  //!< to be sent next, where it has a time
  std::size_t pose_ = 0;
  SensorPoints points_;
  std::map<std::string, live::Link> mountings_;  //!< by frame
  std::deque<Event> due_;  //!< a scan, and its mounting where it is new
};

/** As a SLAM does that closes a loop. */
void RawlogEvents::correct(const io::Trajectory::Entry& odometry)
{
  if (corrected_s_ == 0) corrected_s_ = odometry.time_s;
  if (odometry.time_s < corrected_s_ + slam_every_s_) return;
  const auto T_map_base = slam_.at(odometry.time_s, HUGE_VAL);
  if (!T_map_base) return;
  corrected_s_ = odometry.time_s;
  T_map_odom_ = *T_map_base + (-odometry.T_map_base);
  std::vector<std::pair<double, mrpt::poses::CPose3D>> poses;
  for (const auto& pose : slam_.entries())
    if (pose.time_s <= corrected_s_) poses.emplace_back(pose.time_s, pose.T_map_base);
  path_ = {
      corrected_s_, "/slam/path", "nav_msgs/msg/Path", true,
      live::path_message({corrected_s_, kMap}, poses)};
}

void RawlogEvents::read_scan()
{
  for (auto obs = reader_.next(); obs; obs = reader_.next())
  {
    if (!points_from_observation(*obs, points_) || points_.x_m.empty()) continue;
    const std::string topic = topic_of(points_.sensor_label), frame = topic.substr(1);
    float last_s = 0;
    for (const float t : points_.time_s)
      if (std::isfinite(t)) last_s = std::max(last_s, t);
    const double time_s = points_.stamp_s + last_s;  // a scan is sent when it is whole
    auto& mounting = mountings_[frame];
    if (mounting.child.empty() || mounting.T_parent_child != points_.T_base_sensor)
    {
      mounting = {{points_.stamp_s, kBase}, frame, points_.T_base_sensor};
      std::vector<live::Link> all;
      for (const auto& [name, link] : mountings_) all.push_back(link);
      due_.push_back({time_s, "/tf_static", kTf, true, live::tf_message(all)});
    }
    live::CloudPoints cloud;
    cloud.x_m = points_.x_m;
    cloud.y_m = points_.y_m;
    cloud.z_m = points_.z_m;
    cloud.time_s = points_.time_s;
    if (!points_.channels.empty()) cloud.intensity = points_.channels[0];
    due_.push_back(
        {time_s, topic, "sensor_msgs/msg/PointCloud2", false,
         live::cloud_message({points_.stamp_s, frame}, cloud)});
    return;
  }
}
}  // namespace

std::unique_ptr<Events> events_of_bag(const std::string& path)
{
  return std::make_unique<BagEvents>(path);
}

std::unique_ptr<Events> events_of_rawlog(const std::string& path, const RawlogTopics& options)
{
  return std::make_unique<RawlogEvents>(path, options);
}

}  // namespace talus::app
