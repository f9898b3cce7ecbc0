#include "bag_motion.h"

#include <mrpt/poses/CPose3DQuat.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
/** Whether the user named the topic of these clouds. */
bool is_named(const std::string& topic, const SourceOptions& options)
{
  return options.mounting_of(topic) ||
         std::find(options.topics.begin(), options.topics.end(), topic) != options.topics.end();
}
}  // namespace

BagMotion::BagMotion(
    BagReader& reader, const std::vector<BagRole>& roles, const SourceOptions& options,
    const std::string& path)
    : recorded_times_(options.recorded_times)
{
  read(reader, roles);
  tree_.sort();
  for (auto& topic : pose_topics_) topic.history.sort();
  choose_base(options, path);
  choose_map(options, path);
  if (options.poses.empty()) choose_poses(reader, options);
  if (!options.clouds_in_map)
  {
    find_maps(reader, options);
    find_copies(reader, options);
  }
  if (bad_poses_ > 0)
    remark(
        std::to_string(bad_poses_) +
        " transforms or poses are not used: they are not finite, or "
        "their quaternion is none");
  if (!tree_.conflicts().empty())
    remark(
        "TF has two parents for " + listed({tree_.conflicts().begin(), tree_.conflicts().end()}) +
        ": the one that comes first in the bag is used");
}

void BagMotion::fail_without(
    const std::string& frame, const std::string& option, const std::string& path) const
{
  throw std::runtime_error(
      path + ": no frame " + frame + " (" + option + "). TF has: " + listed(tree_.frames()));
}

void BagMotion::choose_base(const SourceOptions& options, const std::string& path)
{
  const auto is_child = [&](const std::string& frame)
  {
    return std::any_of(
        pose_topics_.begin(), pose_topics_.end(),
        [&](const PoseTopic& t) { return t.child == frame; });
  };
  base_ = options.base_frame;
  if (!base_.empty() && !tree_.has(base_) && !is_child(base_))
    fail_without(base_, "--base-frame", path);
  if (base_.empty()) base_ = tree_.named({"base_link", "base_footprint"});
  for (const auto& topic : pose_topics_)
    if (base_.empty()) base_ = topic.child;
}

void BagMotion::choose_map(const SourceOptions& options, const std::string& path)
{
  const auto is_map = [&](const std::string& frame)
  {
    return std::any_of(
        pose_topics_.begin(), pose_topics_.end(),
        [&](const PoseTopic& t) { return t.map == frame; });
  };
  map_ = options.map_frame;
  if (!map_.empty() && !tree_.has(map_) && !is_map(map_)) fail_without(map_, "--map-frame", path);
  if (!map_.empty()) return;
  for (const char* name : {"map", "odom"})
    if (const auto frame = tree_.named({name});
        map_.empty() && !frame.empty() && !tree_.times_between(frame, base_).empty())
      map_ = frame;
}

/** No sensor stands in it. */
bool BagMotion::is_fixed(const std::string& frame) const
{
  bool is = frame == map_;
  for (const char* name : {"map", "odom", "world"}) is |= frame == name || is_of_robot(frame, name);
  for (const auto& topic : pose_topics_) is |= !topic.child.empty() && frame == topic.map;
  return is && frame != base_;
}

bool BagMotion::has_moved() const
{
  constexpr double kFar_m = 1;
  const auto& all = poses_.entries();
  return std::any_of(
      all.begin(), all.end(),
      [&](const io::Trajectory::Entry& e)
      { return (e.T_map_base - all.front().T_map_base).norm() > kFar_m; });
}

void BagMotion::leave_out(std::size_t topic, const BagReader& reader, const std::string& why)
{
  const auto& name = reader.topics()[topic].name;
  left_out_.push_back(topic);
  remark(name + " is left out: " + why + "; --topic " + name + " takes it");
}

/** Where nothing else is left, these are registered scans. */
void BagMotion::find_maps(const BagReader& reader, const SourceOptions& options)
{
  constexpr std::size_t kMin = 8;  // scans grow by chance
  const bool moves = has_moved();
  const auto leave_out_if = [&](const auto& is_map, const std::string& why)
  {
    std::vector<std::size_t> maps;
    for (const auto& t : cloud_topics_)
      if (!is_left_out(t.topic) && !is_named(reader.topics()[t.topic].name, options) && is_map(t))
        maps.push_back(t.topic);
    if (maps.size() + left_out_.size() == cloud_topics_.size()) return;
    for (const auto topic : maps) leave_out(topic, reader, why + ", as of a map");
  };
  leave_out_if(
      [&](const CloudTopic& t) { return moves && t.grows && t.count >= kMin; },
      "its clouds repeat or grow while the robot moves");
  leave_out_if(
      [&](const CloudTopic& t) { return is_fixed(t.frame); },
      "its points are in a frame that does not move with the robot");
}

/** Of two topics with the same points the one in the frame of the scanner counts, as its rays begin
 * there, else that with more points. */
void BagMotion::find_copies(const BagReader& reader, const SourceOptions& options)
{
  std::vector<const CloudTopic*> scans;
  for (const auto& t : cloud_topics_)
    if (!is_left_out(t.topic)) scans.push_back(&t);
  const auto is_better = [&](const CloudTopic* a, const CloudTopic* b)
  {
    const auto rank = [&](const CloudTopic* t)
    {
      return std::tuple(
          is_named(reader.topics()[t->topic].name, options), t->frame != base_, t->first.points());
    };
    return rank(a) > rank(b);
  };
  std::stable_sort(scans.begin(), scans.end(), is_better);
  const auto mounting = [&](const std::string& frame, std::int64_t stamp_ns)
  { return frame == base_ ? CPose3D() : tree_.T_between(base_, frame, stamp_ns); };
  for (std::size_t i = 1; i < scans.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
    {
      const auto& name = reader.topics()[scans[i]->topic].name;
      const bool is_copy = !is_left_out(scans[k]->topic) && !is_named(name, options) &&
                           (scans[i]->first.are_in(scans[k]->first, mounting) ||
                            scans[k]->first.are_in(scans[i]->first, mounting));
      if (!is_copy) continue;
      leave_out(
          scans[i]->topic, reader,
          "its points are those of " + reader.topics()[scans[k]->topic].name +
              " once more, or some of them");
      break;
    }
}

bool BagMotion::is_left_out(std::size_t topic) const
{
  return std::find(left_out_.begin(), left_out_.end(), topic) != left_out_.end();
}

std::optional<CPose3D> BagMotion::T_base_sensor(
    const std::string& sensor_frame, std::int64_t stamp_ns)
{
  if (!base_.empty() && sensor_frame == base_) return CPose3D();
  if (tree_.connects(base_, sensor_frame)) return tree_.T_between(base_, sensor_frame, stamp_ns);
  if (reported_frames_.insert(sensor_frame).second)
    remark(
        "TF does not say how '" + sensor_frame.substr(0, 60) + "' is mounted on " +
        (base_.empty() ? "the base" : "'" + base_.substr(0, 60) + "'") +
        " (it has: " + listed(tree_.frames()) +
        "): the sensor is taken to be at the base. --base-frame names another base, --mount the "
        "place");
  return CPose3D();
}

std::string BagMotion::topics_text(BagReader& reader) const
{
  std::string text;
  for (const auto& topic : pose_topics_)
    text += (text.empty() ? "" : ", ") + reader.topics()[topic.topic].name.substr(0, 100) + " (" +
            std::to_string(topic.count) + ")";
  return text;
}

const BagMotion::PoseTopic* BagMotion::named_topic(
    BagReader& reader, const SourceOptions& options) const
{
  for (const auto& topic : pose_topics_)
    for (const auto& name : options.topics)
      if (reader.topics()[topic.topic].name == name) return &topic;
  return nullptr;
}

void BagMotion::choose_poses(BagReader& reader, const SourceOptions& options)
{
  const auto* named = named_topic(reader, options);
  if (named) return take_from(*named, reader);
  if (take_from_tf()) return;
  // A path may be a plan; the poses of that have no times of their own.
  const auto count_of = [](const PoseTopic& t)
  { return t.is_path ? std::size_t{t.history.all().size() > 1} : 1 + t.count; };
  const auto most = std::max_element(
      pose_topics_.begin(), pose_topics_.end(),
      [&](const PoseTopic& a, const PoseTopic& b) { return count_of(a) < count_of(b); });
  if (most == pose_topics_.end() || count_of(*most) == 0)
    return remark(
        "the bag has no poses of the base: no chain in TF that moves from map or odom to " +
        (base_.empty() ? "a base" : "'" + base_.substr(0, 60) + "'") +
        ", no Odometry, no PoseStamped, no Path whose poses have times. --poses FILE gives them, "
        "--base-frame and --map-frame name "
        "frames");
  take_from(*most, reader);
  if (pose_topics_.size() > 1)
    remark("these are the most of: " + topics_text(reader) + "; --topic takes those of another");
}

bool BagMotion::take_from_tf()
{
  if (map_.empty() || base_.empty()) return false;
  std::vector<io::Trajectory::Entry> entries;
  for (const auto stamp_ns : tree_.times_between(map_, base_))
    if (const auto T_map_base = tree_.T_between(map_, base_, stamp_ns))
      entries.push_back({seconds(stamp_ns), *T_map_base});
  if (entries.empty()) return false;
  remark("poses are those of '" + base_ + "' in '" + map_ + "' in TF");
  poses_ = io::Trajectory(std::move(entries));
  pose_offsets_ = tf_offsets_;
  return true;
}

void BagMotion::take_from(const PoseTopic& topic, const BagReader& reader)
{
  remark("poses are those of topic " + reader.topics()[topic.topic].name);
  pose_offsets_ = topic.offsets;
  std::vector<io::Trajectory::Entry> entries;
  entries.reserve(topic.history.all().size());
  const bool is_base = topic.child.empty() || topic.child == base_;
  const bool is_connected = !is_base && tree_.connects(topic.child, base_);
  if (!is_base && !is_connected)
    remark(
        "poses of '" + topic.child.substr(0, 60) + "' are taken for those of '" +
        base_.substr(0, 60) + "': TF does not connect them");
  for (const auto& pose : topic.history.all())
  {
    const CPose3D T_map_child{mrpt::poses::CPose3DQuat(pose.pose)};
    const auto T_child_base = is_connected ? tree_.T_between(topic.child, base_, pose.stamp_ns)
                                           : std::optional<CPose3D>(CPose3D());
    if (T_child_base) entries.push_back({seconds(pose.stamp_ns), T_map_child + *T_child_base});
  }
  poses_ = io::Trajectory(std::move(entries));
}

}  // namespace talus::import
