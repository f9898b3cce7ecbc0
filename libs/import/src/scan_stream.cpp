#include <talus/import/scan_stream.h>
#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <mrpt/core/Clock.h>
#include <mrpt/poses/CPose3DQuat.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "bag_clock.h"
#include "bag_clouds.h"
#include "bag_frames.h"
#include "bag_messages.h"
#include "bag_topics.h"
#include "cdr_reader.h"
#include "placed_scans.h"
#include "point_times.h"

using mrpt::poses::CPose3D;

namespace talus::import
{
namespace
{
constexpr std::int64_t kSecond_ns = 1000000000;
constexpr std::int64_t kKept_ns = 10 * kSecond_ns;  //!< of transforms and poses
constexpr double kSettle_s = 1;  //!< within which a better source of poses is heard, too
constexpr double kMaxGap_s = 0.5;  //!< between poses, as talus-map has it
constexpr std::size_t kMaxWaiting = 20;  //!< clouds: a map that lags behind is of no use

std::int64_t nanoseconds(double time_s) { return static_cast<std::int64_t>(time_s * 1e9); }

/** Nothing is packed: points have bytes of their own. */
std::uint64_t max_points(const CloudMessage& cloud)
{
  return std::max<std::uint64_t>(std::uint64_t{1} << 20, cloud.data.size());
}

/** What is known of one topic with clouds. */
struct Sensor
{
  bool is_wanted = true;
  std::string frame;
  bool is_of_other_order = false;  //!< of bytes, than it says
  bool learns_no_returns = true;
  NoReturns no_returns;
  std::vector<std::array<double, 3>> no_return_points;
  PointClock clock;
  int clock_scans = 0;  //!< by which its unit is estimated
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  StampOffsets offsets;
  std::deque<double> apart_s;  //!< its last scans

  /** How many scans are missing before one so much later than the one before. */
  std::size_t missing(double gap_s);
};

std::size_t Sensor::missing(double gap_s)
{
  constexpr std::size_t kMin = 3, kMax = 20;
  constexpr double kMaxMissing = 1000;
  std::size_t count = 0;
  if (apart_s.size() >= kMin)
  {
    const double period_s = io::quantile(std::vector(apart_s.begin(), apart_s.end()), 0.5);
    count = static_cast<std::size_t>(std::min(std::round(gap_s / period_s), kMaxMissing));
  }
  apart_s.push_back(gap_s);
  if (apart_s.size() > kMax) apart_s.pop_front();
  return count > 1 ? count - 1 : 0;
}

/** A cloud whose poses are not known yet. */
struct Waiting
{
  ImportedScan scan;  //!< without its mounting
  std::string frame;
  std::int64_t stamp_ns = 0;
  double first_s = 0, last_s = 0;  //!< times of its points, after the stamp
  double since_s = 0;
};
}  // namespace

StreamPath path_from(std::string_view message)
{
  StreamPath path{read_header(message).frame, {}};
  for_each_pose(
      message,
      [&](const FrameTransform& pose)
      {
        if (!pose.T_parent_child || pose.parent.stamp_ns <= 0) return;
        const CPose3D T_map_base{mrpt::poses::CPose3DQuat(*pose.T_parent_child)};
        path.poses.push_back({seconds(pose.parent.stamp_ns), T_map_base});
      });
  return path;
}
bool is_path(const std::string& type) { return role_of({"", type, "cdr"}) == BagRole::Path; }

struct ScanStream::Impl
{
  Impl(const SourceOptions& o, double wait_s) : options(o), max_wait_s(wait_s) {}

  void take(const BagTopic& topic, BagRole role, std::string_view message, double now_s);
  void take_cloud(const BagTopic& from, std::string_view message, double now_s);
  void meet(const std::string& topic, const CloudMessage& cloud);
  void await(const std::string& topic, Sensor& sensor, const MessageHeader& header, double now_s);
  void take_odometry(const std::string& topic, FrameTransform pose, double now_s);
  bool is_of_this_time(std::int64_t stamp_ns, double now_s);
  void choose_frames(double now_s);
  void add_poses(double now_s);
  void add_pose(
      std::int64_t stamp_ns, const CPose3D& T_map_base, const CPose3D& T_map_odom = CPose3D());
  std::optional<CPose3D> T_base_sensor(const Waiting& cloud) const;
  bool has_poses_until(const Waiting& cloud, double last_s) const;
  const io::Trajectory& recent_poses() const;
  std::string why_late_is(const Waiting& cloud, bool has_mounting) const;
  void leave_out(const std::string& topic, Sensor& sensor, const std::string& why);
  void refuse(const BagTopic& topic, const std::string& why);
  void say(const std::string& text)
  {
    if (said.insert(text).second) news.push_back(text);
  }

  SourceOptions options;
  double max_wait_s;
  FrameTree tree;
  std::string base, map;  //!< empty: not known yet
  std::string odometry;  //!< topic of the poses, where TF has none
  double first_chain_s = -1, first_odometry_s = -1;
  std::int64_t last_pose_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t newest_ns = 0;  //!< of transforms and odometry
  double newest_at_s = 0;
  std::size_t other_times = 0;  //!< transforms in a row whose time is another
  std::deque<io::Trajectory::Entry> recent;
  mutable std::optional<io::Trajectory> trajectory;  //!< of these
  std::vector<StreamPose> new_poses;
  StampOffsets pose_offsets;
  std::map<std::string, Sensor> sensors;
  std::deque<Waiting> waiting;
  ScanFile file;
  StreamCounts counts;
  std::string why_late, why_refused;  //!< of the last one
  std::string why_back;  //!< where stamps have gone back
  bool has_ended = false;
  bool is_last_late = false;  //!< of all clouds
  std::vector<std::string> news;
  std::set<std::string> said;  //!< texts
  std::set<std::string> refused;  //!< topics of which that was said
};

ScanStream::ScanStream(const SourceOptions& options, double max_wait_s)
    : impl_(std::make_unique<Impl>(options, max_wait_s))
{
  impl_->file.values = options.values;
  impl_->file.scale = options.scale;
}
ScanStream::~ScanStream() = default;

bool ScanStream::reads(const std::string& topic, const std::string& type)
{
  const auto role = role_of({topic, type, "cdr"});
  return role != BagRole::None && role != BagRole::Pose && role != BagRole::Path;
}
bool ScanStream::is_cloud(const std::string& type)
{
  return role_of({"", type, "cdr"}) == BagRole::Cloud;
}
bool ScanStream::wants(const std::string& topic) const
{
  const auto sensor = impl_->sensors.find(topic);
  return sensor == impl_->sensors.end() || sensor->second.is_wanted;
}

void ScanStream::add(
    const std::string& topic, const std::string& type, std::string_view message, double now_s)
{
  const BagTopic named{topic, type, "cdr"};
  try
  {
    impl_->take(named, role_of(named), message, now_s);
  }
  catch (const CdrError& e)
  {
    impl_->refuse(named, "a message of " + topic + " " + e.what() + ".");
  }
  catch (const std::runtime_error& e)
  {
    impl_->refuse(named, e.what());
  }
}

void ScanStream::Impl::refuse(const BagTopic& topic, const std::string& why)
{
  ++counts.refused;
  if (role_of(topic) == BagRole::Cloud) why_refused = why;
  if (refused.insert(topic.name).second) say(why + " It is left out, as are others like it");
}

void ScanStream::Impl::take(
    const BagTopic& topic, BagRole role, std::string_view message, double now_s)
{
  if (role == BagRole::Cloud) return take_cloud(topic, message, now_s);
  if (role == BagRole::Odometry) return take_odometry(topic.name, read_odometry(message), now_s);
  if (role != BagRole::Tf && role != BagRole::TfStatic) return;
  const bool is_static = role == BagRole::TfStatic;
  for_each_link(
      message,
      [&](const FrameTransform& link)
      {
        if (!is_static && !is_of_this_time(link.parent.stamp_ns, now_s)) return;
        if (!is_static) pose_offsets.add(nanoseconds(now_s), link.parent.stamp_ns);
        tree.add(link, is_static);
      });
  if (!tree.conflicts().empty())
    say("TF has two parents for '" + tree.conflicts().begin()->substr(0, 60) +
        "': the one that came first is used");
  add_poses(now_s);
}

/** One stamp of a wrong clock must not hold up all that follow. What is ahead of the newest by more
 * than the time that has passed is of another clock, unless all is. */
bool ScanStream::Impl::is_of_this_time(std::int64_t stamp_ns, double now_s)
{
  constexpr double kOther_s = 5;
  constexpr std::size_t kEnough = 50;
  const double ahead_s = newest_ns == 0 ? 0 : seconds(stamp_ns - newest_ns);
  if (ahead_s < -kOther_s)
  {
    why_back =
        "stamps have gone back by " + fixed_text(-ahead_s, 1) +
        " s: what is older than the map is left out. After a restart of the robot's clock or "
        "of a bag, start talus-live anew";
    if (refused.insert("stamps").second) say(why_back);
    return false;
  }
  const bool is_other = ahead_s > kOther_s + (now_s - newest_at_s);
  other_times = is_other ? other_times + 1 : 0;
  if (is_other && other_times < kEnough) return false;
  if (stamp_ns <= newest_ns) return true;
  newest_ns = stamp_ns;
  newest_at_s = now_s;
  why_back.clear();
  return true;
}

void ScanStream::Impl::take_odometry(const std::string& topic, FrameTransform pose, double now_s)
{
  if (!pose.T_parent_child || (!odometry.empty() && topic != odometry)) return;
  if (first_odometry_s < 0) first_odometry_s = now_s;
  choose_frames(now_s);
  if (map.empty() && now_s - first_odometry_s > kSettle_s)
  {
    odometry = topic;
    map = pose.parent.frame;
    if (base.empty()) base = pose.child;
    say("poses are those of topic " + topic + ", of '" + pose.child + "' in '" + map + "'");
  }
  if (odometry.empty() || !is_of_this_time(pose.parent.stamp_ns, now_s)) return;
  pose_offsets.add(nanoseconds(now_s), pose.parent.stamp_ns);
  const CPose3D T_map_child{mrpt::poses::CPose3DQuat(*pose.T_parent_child)};
  const bool is_base = pose.child.empty() || pose.child == base;
  const bool is_connected = is_base || tree.connects(pose.child, base);
  if (!is_connected)
    say("poses of '" + pose.child + "' are taken for those of '" + base +
        "': TF does not connect them");
  const auto T_child_base = is_base || !is_connected
                                ? std::optional<CPose3D>(CPose3D())
                                : tree.T_between(pose.child, base, pose.parent.stamp_ns);
  if (T_child_base) add_pose(pose.parent.stamp_ns, T_map_child + *T_child_base);
}

void ScanStream::Impl::choose_frames(double now_s)
{
  if (!map.empty()) return;
  base =
      options.base_frame.empty() ? tree.named({"base_link", "base_footprint"}) : options.base_frame;
  std::vector<std::string> maps = {tree.named({"map"}), tree.named({"odom"})};
  if (!options.map_frame.empty()) maps = {options.map_frame};
  for (const auto& name : maps)
  {
    if (base.empty() || name.empty() || tree.times_between(name, base).empty()) continue;
    if (first_chain_s < 0) first_chain_s = now_s;
    const bool is_best = &name == &maps.front();
    if (!is_best && now_s - first_chain_s < kSettle_s) return;
    map = name;
    say("poses are those of '" + base + "' in '" + map + "' in TF" +
        (is_best ? "" : ", as there is no map; --map-frame map waits for one"));
    return;
  }
}

void ScanStream::Impl::add_poses(double now_s)
{
  tree.sort();
  choose_frames(now_s);
  if (map.empty() || !odometry.empty()) return;
  const auto until = tree.known_until(map, base);
  const auto odom = tree.child_towards(map, base);
  for (const auto stamp_ns : tree.times_between(map, base))
    if (until && stamp_ns > last_pose_ns && stamp_ns <= *until)
      if (const auto T_map_base = tree.T_between(map, base, stamp_ns))
        add_pose(
            stamp_ns, *T_map_base,
            odom == base ? CPose3D() : tree.T_between(map, odom, stamp_ns).value_or(CPose3D()));
  tree.forget_before(newest_ns - kKept_ns);
}

void ScanStream::Impl::add_pose(
    std::int64_t stamp_ns, const CPose3D& T_map_base, const CPose3D& T_map_odom)
{
  constexpr std::int64_t kStep_ns = 5000000;  //!< as histories of TF have it
  if (last_pose_ns > 0 && stamp_ns < last_pose_ns + kStep_ns) return;
  last_pose_ns = stamp_ns;
  const auto entry = io::as_in_tum({seconds(stamp_ns), T_map_base});
  recent.push_back(entry);
  new_poses.push_back({entry, T_map_odom});
  while (recent.front().time_s < entry.time_s - seconds(kKept_ns)) recent.pop_front();
  trajectory.reset();
}

void ScanStream::Impl::leave_out(const std::string& topic, Sensor& sensor, const std::string& why)
{
  sensor.is_wanted = false;
  say(topic + " is left out: " + why + "; --topic " + topic + " takes it");
}

/** A robot publishes more than its scans: maps, and filtered copies. */
void ScanStream::Impl::meet(const std::string& topic, const CloudMessage& cloud)
{
  Sensor& sensor = sensors[topic];
  sensor.frame = cloud.header.frame;
  sensor.is_of_other_order = is_of_other_order(cloud, topic, max_points(cloud));
  const auto& named = options.topics;
  if (std::find(named.begin(), named.end(), topic) != named.end()) return;
  for (const char* name : {"map", "odom", "world"})
    if (sensor.frame == name || sensor.frame == map || is_of_robot(sensor.frame, name))
      return leave_out(
          topic, sensor,
          "its points are in '" + sensor.frame + "', which does not move with the robot");
  for (const auto& [other, its] : sensors)
    if (other != topic && its.is_wanted && its.frame == sensor.frame)
      return leave_out(
          topic, sensor, "its points are in '" + sensor.frame + "', as those of " + other);
}

void ScanStream::Impl::take_cloud(const BagTopic& from, std::string_view message, double now_s)
{
  const std::string& topic = from.name;
  auto cloud = read_cloud(message, from.type);
  if (sensors.count(topic) == 0) meet(topic, cloud);
  Sensor& sensor = sensors[topic];
  if (!sensor.is_wanted) return;
  cloud.is_big_endian ^= sensor.is_of_other_order;
  const std::int64_t now_ns = nanoseconds(now_s);
  const auto stamp_ns = cloud.header.stamp_ns == 0 ? now_ns : cloud.header.stamp_ns;
  sensor.offsets.add(now_ns, cloud.header.stamp_ns);
  if (stamp_ns <= sensor.last_ns)
  {
    ++counts.stale;
    return;
  }
  file.no_return_points = sensor.no_return_points;
  collect_points(cloud, topic, file, max_points(cloud));
  if (sensor.learns_no_returns && !(sensor.learns_no_returns = sensor.no_returns.add(file)))
    sensor.no_return_points = sensor.no_returns.points();
  await(topic, sensor, cloud.header, now_s);
}

/** The points that were read, as a scan that has no pose yet. */
void ScanStream::Impl::await(
    const std::string& topic, Sensor& sensor, const MessageHeader& header, double now_s)
{
  Waiting cloud;
  cloud.frame = header.frame;
  std::int64_t& stamp_ns = cloud.stamp_ns;
  stamp_ns = header.stamp_ns == 0 ? nanoseconds(now_s) : header.stamp_ns;
  cloud.since_s = now_s;
  auto& scan = cloud.scan;
  scan.sensor_label = topic;
  scan.time_s = seconds(stamp_ns);
  constexpr int kClockScans = 10;
  if (sensor.clock_scans < kClockScans)
  {
    ++sensor.clock_scans;
    sensor.clock.add(file, scan.time_s);
  }
  sensor.clock.leave_out_broken(file);
  scan.point_time_s = sensor.clock.times_since(scan.time_s, file);
  take_points(file, scan);
  if (is_in_world(scan))
    throw CdrError("has points in world coordinates, not in the frame of the sensor");
  if (!scan.point_time_s.empty())
  {
    const auto [first, last] =
        std::minmax_element(scan.point_time_s.begin(), scan.point_time_s.end());
    cloud.first_s = *first;
    cloud.last_s = *last;
  }
  if (header.stamp_ns == 0)  // it came after its last point
  {
    stamp_ns -= nanoseconds(cloud.last_s);
    scan.time_s = seconds(stamp_ns);
  }
  if (sensor.last_ns > 0) counts.missing += sensor.missing(seconds(stamp_ns - sensor.last_ns));
  sensor.last_ns = stamp_ns;
  if (scan.x_m.empty()) throw CdrError("has no points");
  waiting.push_back(std::move(cloud));
  if (waiting.size() <= kMaxWaiting) return;
  waiting.pop_front();
  ++counts.dropped;
}

std::optional<CPose3D> ScanStream::Impl::T_base_sensor(const Waiting& cloud) const
{
  if (const auto* given = options.mounting_of(cloud.scan.sensor_label)) return *given;
  if (!base.empty() && cloud.frame == base) return CPose3D();
  return tree.T_between(base, cloud.frame, cloud.stamp_ns);
}

const io::Trajectory& ScanStream::Impl::recent_poses() const
{
  if (!trajectory) trajectory.emplace(std::vector(recent.begin(), recent.end()));
  return *trajectory;
}

/** Whether the poses reach from the stamp to this time after it, so that none that comes later
 * changes them. */
bool ScanStream::Impl::has_poses_until(const Waiting& cloud, double last_s) const
{
  constexpr double kStep_s = 1e-6;  // more than what logs round
  const double stamp_s = mrpt::Clock::toDouble(mrpt::Clock::fromDouble(cloud.scan.time_s));
  const double until_s = last_s > 0 ? stamp_s + last_s + kStep_s : stamp_s;
  if (!has_ended && (recent.empty() || recent.back().time_s < until_s)) return false;
  return recent_poses().at(stamp_s, kMaxGap_s).has_value();
}

std::string ScanStream::Impl::why_late_is(const Waiting& cloud, bool has_mounting) const
{
  if (recent.empty()) return "no poses have come yet";
  const std::string topic = cloud.scan.sensor_label;
  if (!has_mounting)
    return "TF does not say where '" + cloud.frame.substr(0, 60) + "' of " + topic +
           " is mounted on '" + base + "'; --mount " + topic + "=X,Y,Z,YAW,PITCH,ROLL does";
  const double newer_s = recent.back().time_s - cloud.scan.time_s;
  return "no pose of '" + base + "' in '" + map + "' at its time: the newest one is " +
         fixed_text(std::abs(newer_s), 2) +
         (newer_s < 0                                 ? " s older; --max-wait waits longer"
          : cloud.scan.time_s < recent.front().time_s ? " s newer, and the first one, too"
                                                      : " s newer, and there is a gap");
}

bool ScanStream::next(ImportedScan& scan, double now_s)
{
  auto& me = *impl_;
  for (; !me.waiting.empty(); me.waiting.pop_front())
  {
    auto& cloud = me.waiting.front();
    const auto T_base_sensor = me.T_base_sensor(cloud);
    const bool is_whole = T_base_sensor && me.has_poses_until(cloud, cloud.last_s);
    if (!is_whole && now_s - cloud.since_s < me.max_wait_s) return false;
    if (!is_whole && (!T_base_sensor || !me.has_poses_until(cloud, 0)))
    {
      ++me.counts.late;
      me.is_last_late = true;
      me.why_late = me.why_late_is(cloud, T_base_sensor.has_value());
      continue;
    }
    if (!is_whole) ++me.counts.without_times;
    ++me.counts.scans;
    me.is_last_late = false;
    me.why_refused.clear();
    scan = std::move(cloud.scan);
    if (!is_whole) scan.point_time_s.clear();
    scan.T_base_sensor = *T_base_sensor;
    me.waiting.pop_front();
    return true;
  }
  return false;
}

void ScanStream::end() { impl_->has_ended = true; }
const io::Trajectory& ScanStream::poses() const { return impl_->recent_poses(); }
std::vector<StreamPose> ScanStream::take_new_poses() { return std::exchange(impl_->new_poses, {}); }
const std::string& ScanStream::map_frame() const { return impl_->map; }
StreamCounts ScanStream::counts() const { return impl_->counts; }
std::vector<std::string> ScanStream::take_news() { return std::exchange(impl_->news, {}); }

std::string ScanStream::why_nothing() const
{
  const auto& me = *impl_;
  if (!me.why_refused.empty()) return me.why_refused;
  if (me.sensors.empty()) return "no cloud has come";
  if (me.recent.empty())
    return "no poses: neither a chain of TF that moves from map or odom to " +
           (me.base.empty() ? "base_link or base_footprint" : "'" + me.base + "'") +
           ", nor Odometry (frames of TF: " + listed(me.tree.frames()) +
           "). --map-frame and --base-frame name frames";
  if (!me.why_back.empty()) return me.why_back;
  for (const auto& [topic, sensor] : me.sensors)
    if (const auto clock = sensor.offsets.with(me.pose_offsets).warning; !clock.empty())
      return topic + ": " + clock + ". Give both machines one clock (chrony, PTP)";
  return me.is_last_late ? me.why_late : "";
}

std::string ScanStream::why_late() const { return impl_->why_late; }

}  // namespace talus::import
