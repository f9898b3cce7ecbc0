// What a bag says of frames and poses, read message by message.
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <stdexcept>

#include "bag_motion.h"
#include "cdr_reader.h"

namespace talus::import
{
std::uint64_t most_points(const BagReader& reader)
{
  constexpr std::uint64_t kFewPoints = std::uint64_t{1} << 20;
  return std::max(kFewPoints, reader.stored_bytes());
}

void BagMotion::read(BagReader& reader, const std::vector<BagRole>& roles)
{
  std::vector<bool> wanted;
  wanted.reserve(roles.size());
  for (const auto role : roles) wanted.push_back(role != BagRole::None);
  clouds_left_ = static_cast<std::size_t>(std::count(roles.begin(), roles.end(), BagRole::Cloud));
  reader.start(std::move(wanted));
  BagMessage message;
  while (reader.next(message))
  {
    try
    {
      read_message(reader, message, roles[message.topic]);
    }
    catch (const CdrError& e)
    {
      throw std::runtime_error(reader.place() + " " + e.what() + ". Copy the bag again.");
    }
    require_room(reader);
  }
}

/** Drops what is not needed. TF that packs very well must not take the memory of the machine. */
void BagMotion::require_room(const BagReader& reader)
{
  constexpr std::size_t kFew = 150000, kMinBytes = 32;
  const std::size_t most = kFew + reader.bytes() / kMinBytes;
  const bool is_full = tree_.size() + poses_held_ > most;
  if (tree_.size() > prune_at_ || is_full) prune(is_full);
  if (is_full && tree_.size() + poses_held_ > most)
    throw std::runtime_error(
        reader.place() + ": is one of more than " + std::to_string(most) +
        " transforms and poses in a bag of " + std::to_string(reader.bytes()) +
        " bytes, which hold no more. --topic names the topic of the poses, --poses a file");
}

void BagMotion::read_message(BagReader& reader, const BagMessage& message, BagRole role)
{
  const auto payload = reader.payload();
  switch (role)
  {
    case BagRole::Cloud:
      add_cloud(reader, message, payload);
      break;
    case BagRole::Tf:
    case BagRole::TfStatic:
      add_links(payload, message, role == BagRole::TfStatic);
      break;
    case BagRole::Odometry:
      add_pose(message, read_odometry(payload));
      break;
    case BagRole::Pose:
      add_pose(message, read_pose(payload));
      break;
    case BagRole::Path:
      add_path(message, payload);
      break;
    case BagRole::None:
      break;
  }
}

std::map<std::size_t, std::vector<std::array<double, 3>>> BagMotion::no_returns() const
{
  std::map<std::size_t, std::vector<std::array<double, 3>>> places;
  for (const auto& topic : cloud_topics_) places[topic.topic] = topic.no_returns.points();
  return places;
}

const PointClock& BagMotion::clock(std::size_t topic) const
{
  static const PointClock kNoClock;
  for (const auto& t : cloud_topics_)
    if (t.topic == topic) return t.clock;
  return kNoClock;
}

bool BagMotion::is_of_other_order(std::size_t topic) const
{
  return std::any_of(
      cloud_topics_.begin(), cloud_topics_.end(),
      [&](const CloudTopic& t) { return t.topic == topic && t.is_of_other_order; });
}

/** How it is mounted, whether it is a map and has points of no return: by the first few scans.
 */
void BagMotion::add_cloud(BagReader& reader, const BagMessage& message, std::string_view payload)
{
  auto cloud = read_cloud(payload, reader.topics()[message.topic].type);
  auto known = std::find_if(
      cloud_topics_.begin(), cloud_topics_.end(),
      [&](const CloudTopic& t) { return t.topic == message.topic; });
  if (known == cloud_topics_.end())
  {
    known = cloud_topics_.insert(known, CloudTopic());
    known->topic = message.topic;
    known->frame = cloud.header.frame;
    --clouds_left_;
  }
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  const auto hash = std::hash<std::string_view>()(cloud.data);
  known->grows = known->count++ == 0 || points > known->points || hash == known->hash;
  known->points = points;
  known->hash = hash;
  if (known->needs_look)
  {
    if (known->count == 1)
      known->is_of_other_order =
          talus::import::is_of_other_order(cloud, reader.place(), most_points(reader));
    cloud.is_big_endian ^= known->is_of_other_order;
    ScanFile points_of_cloud;
    collect_points(cloud, reader.place(), points_of_cloud, most_points(reader));
    const auto stamp_ns = cloud.header.stamp_ns == 0 ? message.log_time_ns : cloud.header.stamp_ns;
    known->clock.add(points_of_cloud, 1e-9 * static_cast<double>(stamp_ns));
    known->first.add(points_of_cloud, cloud.header.frame, stamp_ns);
    known->needs_look = known->no_returns.add(points_of_cloud);
  }
  if (!known->grows && !known->needs_look) reader.ignore(message.topic);
}

/** Stamps of another clock than that of the recorder are of no use among those of scans. */
void BagMotion::set_time(MessageHeader& header, const BagMessage& message) const
{
  const double off_s = 1e-9 * static_cast<double>(header.stamp_ns - message.log_time_ns);
  if (recorded_times_ && std::abs(off_s) > kOtherClock_s) header.stamp_ns = message.log_time_ns;
}

void BagMotion::add_links(std::string_view payload, const BagMessage& message, bool is_static)
{
  for_each_link(
      payload,
      [&](FrameTransform link)
      {
        set_time(link.parent, message);
        if (!is_static) tf_offsets_.add(message.log_time_ns, link.parent.stamp_ns);
        bad_poses_ += link.T_parent_child ? 0 : 1;
        tree_.add(link, is_static);
      });
}

BagMotion::PoseTopic& BagMotion::pose_topic(std::size_t topic, const FrameTransform& pose)
{
  for (auto& known : pose_topics_)
    if (known.topic == topic) return known;
  pose_topics_.push_back({topic, pose.parent.frame, pose.child, {}, 0, {}});
  return pose_topics_.back();
}

void BagMotion::add_pose(const BagMessage& message, FrameTransform pose)
{
  set_time(pose.parent, message);
  if (!pose.T_parent_child)
  {
    ++bad_poses_;
    return;
  }
  auto& known = pose_topic(message.topic, pose);
  poses_held_ += known.history.add(pose.parent.stamp_ns, *pose.T_parent_child) ? 1 : 0;
  ++known.count;
  known.offsets.add(message.log_time_ns, pose.parent.stamp_ns);
}

/** A SLAM writes it again and again, with all poses so far: the last one counts. */
void BagMotion::add_path(const BagMessage& message, std::string_view payload)
{
  FrameTransform path;
  path.parent = read_header(payload);
  auto& known = pose_topic(message.topic, path);
  known.is_path = true;
  poses_held_ -= known.history.all().size();
  known.history.clear();
  const std::int64_t now_ns = path.parent.stamp_ns > 0 ? path.parent.stamp_ns : message.log_time_ns;
  std::int64_t last_ns = 0;
  for_each_pose(
      payload,
      [&](const FrameTransform& pose)
      {
        bad_poses_ += pose.T_parent_child ? 0 : 1;
        // The poses of a plan are in the future, or have one time.
        const bool is_past = pose.parent.stamp_ns > last_ns && pose.parent.stamp_ns <= now_ns;
        if (!pose.T_parent_child || !is_past) return;
        last_ns = pose.parent.stamp_ns;
        poses_held_ += known.history.add(last_ns, *pose.T_parent_child) ? 1 : 0;
      });
  known.count = known.history.all().size();
  known.offsets.add(message.log_time_ns, last_ns);
}

/** A topic of clouds without a single message must not keep what nobody needs. */
void BagMotion::prune(bool is_full)
{
  if (clouds_left_ == 0 || is_full)
  {
    std::vector<std::string> ends;
    for (const auto& topic : cloud_topics_) ends.push_back(topic.frame);
    for (const auto& frame : tree_.frames())
      for (const char* base : {"base_link", "base_footprint"})
        if (frame == base || is_of_robot(frame, base)) ends.push_back(frame);
    for (const auto& topic : pose_topics_) ends.push_back(topic.child);
    ends.push_back(base_);
    tree_.keep_chains_of(ends);
  }
  prune_at_ = std::max(kPruneAt, 2 * tree_.size());
}

}  // namespace talus::import
