#include <talus/io/trajectory.h>

#include "packed_file.h"

#include <mrpt/math/slerp.h>
#include <talus/io/rawlog_reader.h>
#include <mrpt/core/Clock.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

using mrpt::obs::CObservation;
using mrpt::poses::CPose3D;

namespace talus::io
{
namespace
{
/** Stamps written with fewer digits than they were taken with still meet their pose. */
constexpr double kStampTolerance_s = 1e-3;

CPose3D interpolate(const Trajectory::Entry& a, const Trajectory::Entry& b, double time_s)
{
  const double t = (time_s - a.time_s) / (b.time_s - a.time_s);
  mrpt::math::CQuaternionDouble qa, qb, q;
  a.T_map_base.getAsQuaternion(qa);
  b.T_map_base.getAsQuaternion(qb);
  mrpt::math::slerp(qa, qb, t, q);
  q.normalize();
  const auto between = [t](double from, double to) { return from + t * (to - from); };
  return CPose3D(
      q, between(a.T_map_base.x(), b.T_map_base.x()), between(a.T_map_base.y(), b.T_map_base.y()),
      between(a.T_map_base.z(), b.T_map_base.z()));
}

using Entries = std::vector<Trajectory::Entry>;
using EntriesByLabel = std::map<std::string, Entries>;

/** What a log says about where the robot was, by kind of source. */
class LogPoses
{
 public:
  void add(const mrpt::serialization::CSerializable& object);
  /** Those that are not finite are none. */
  Trajectory best(std::string& source);

 private:
  void add_observation(const CObservation& obs);
  void add_frame(const mrpt::obs::CSensoryFrame& frame);
  void add_actions(const mrpt::obs::CActionCollection& actions);

  EntriesByLabel robot_poses_, odometry_;
  Entries integrated_;  //!< from the movements between sensory frames
  CPose3D T_origin_base_;
  bool has_movements_ = false;
};

void LogPoses::add(const mrpt::serialization::CSerializable& object)
{
  if (auto* obs = dynamic_cast<const CObservation*>(&object))
    add_observation(*obs);
  else if (auto* frame = dynamic_cast<const mrpt::obs::CSensoryFrame*>(&object))
    add_frame(*frame);
  else if (auto* actions = dynamic_cast<const mrpt::obs::CActionCollection*>(&object))
    add_actions(*actions);
}

void LogPoses::add_observation(const CObservation& obs)
{
  if (obs.timestamp == INVALID_TIMESTAMP) return;
  const double time_s = mrpt::Clock::toDouble(obs.timestamp);
  if (auto* pose = dynamic_cast<const mrpt::obs::CObservationRobotPose*>(&obs))
    robot_poses_[obs.sensorLabel].push_back({time_s, pose->pose.mean + (-pose->sensorPose)});
  else if (auto* odometry = dynamic_cast<const mrpt::obs::CObservationOdometry*>(&obs))
    odometry_[obs.sensorLabel].push_back({time_s, CPose3D(odometry->odometry)});
}

/** All observations of a sensory frame are taken at one pose: what the format means. */
void LogPoses::add_frame(const mrpt::obs::CSensoryFrame& frame)
{
  for (const auto& obs : frame)
  {
    add_observation(*obs);
    if (obs->timestamp != INVALID_TIMESTAMP)
      integrated_.push_back({mrpt::Clock::toDouble(obs->timestamp), T_origin_base_});
  }
}

void LogPoses::add_actions(const mrpt::obs::CActionCollection& actions)
{
  CPose3D increment;
  if (!actions.getFirstMovementEstimationMean(increment)) return;
  T_origin_base_ = T_origin_base_ + increment;
  has_movements_ = true;
}

void leave_out_not_finite(Entries& poses)
{
  const auto is_none = [](const Trajectory::Entry& e) { return !is_finite(e.T_map_base); };
  poses.erase(std::remove_if(poses.begin(), poses.end(), is_none), poses.end());
}

/** Sources of the same kind are never mixed: the label with the most poses wins. */
const EntriesByLabel::value_type* largest(const EntriesByLabel& by_label)
{
  const auto it = std::max_element(
      by_label.begin(), by_label.end(),
      [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  return it == by_label.end() || it->second.empty() ? nullptr : &*it;
}

Trajectory LogPoses::best(std::string& source)
{
  for (auto* by_label : {&robot_poses_, &odometry_})
    for (auto& entry : *by_label) leave_out_not_finite(entry.second);
  leave_out_not_finite(integrated_);
  if (const auto frames = robot_poses_.find(kKeyFrames); frames != robot_poses_.end())
  {
    source = kKeyFrames;
    return Trajectory(frames->second);
  }
  if (const auto* poses = largest(robot_poses_))
  {
    source = "CObservationRobotPose '" + poses->first + "'";
    return Trajectory(poses->second);
  }
  if (const auto* poses = largest(odometry_))
  {
    source = "CObservationOdometry '" + poses->first + "'";
    return Trajectory(poses->second);
  }
  if (has_movements_ && !integrated_.empty())
  {
    source = "movements of the action pairs";
    return Trajectory(integrated_);
  }
  source = "none";
  return {};
}
}  // namespace

Trajectory::Trajectory(std::vector<Entry> entries) : entries_(std::move(entries))
{
  for (const Entry& e : entries_)
    if (!std::isfinite(e.time_s) || !is_finite(e.T_map_base))
      throw std::invalid_argument("a time or a pose of a trajectory is not finite");
  std::stable_sort(
      entries_.begin(), entries_.end(),
      [](const Entry& a, const Entry& b) { return a.time_s < b.time_s; });
  // From the back: the first that unique() meets, the one that stays, is the last that was given.
  const auto last = std::unique(
      entries_.rbegin(), entries_.rend(),
      [](const Entry& a, const Entry& b) { return a.time_s == b.time_s; });
  entries_.erase(entries_.begin(), last.base());
}

Trajectory Trajectory::levelled(double& turned_rad) const
{
  double up_x = 0, up_y = 0, up_z = 0;  // mean of the axes of the base, by the path
  for (std::size_t i = 0; i < entries_.size(); ++i)
  {
    constexpr double kStanding_m = 1e-6;  // what stands still counts where nothing moves
    const CPose3D& T = entries_[i].T_map_base;
    const double path_m = kStanding_m + (i > 0 ? T.distanceTo(entries_[i - 1].T_map_base) : 0);
    const auto& R = T.getRotationMatrix();
    up_x += R(0, 2) * path_m;
    up_y += R(1, 2) * path_m;
    up_z += R(2, 2) * path_m;
  }
  turned_rad = 0;
  const double across = std::hypot(up_x, up_y), length = std::hypot(across, up_z);
  if (!(across > 1e-9 * length) || !(up_z > -0.9 * length)) return *this;
  turned_rad = std::atan2(across, up_z);
  const double s = std::sin(turned_rad / 2) / across;
  const CPose3D turn(
      mrpt::math::CQuaternionDouble(std::cos(turned_rad / 2), up_y * s, -up_x * s, 0), 0, 0, 0);
  const auto& first = entries_.front().T_map_base;
  const CPose3D about(first.x(), first.y(), first.z(), 0, 0, 0);
  auto entries = entries_;
  for (Entry& e : entries) e.T_map_base = about + turn + ((-about) + e.T_map_base);
  return Trajectory(std::move(entries));
}

std::optional<CPose3D> Trajectory::at(double time_s, double max_gap_s) const
{
  if (!std::isfinite(time_s)) return std::nullopt;
  const auto after = std::lower_bound(
      entries_.begin(), entries_.end(), time_s,
      [](const Entry& e, double t) { return e.time_s < t; });
  const bool has_after = after != entries_.end();
  const bool has_before = after != entries_.begin();
  if (has_after && after->time_s == time_s) return after->T_map_base;
  if (has_after && has_before && after->time_s - (after - 1)->time_s <= max_gap_s)
    return interpolate(*(after - 1), *after, time_s);

  const double to_after = has_after ? after->time_s - time_s : HUGE_VAL;
  const double to_before = has_before ? time_s - (after - 1)->time_s : HUGE_VAL;
  if (std::min(to_after, to_before) > kStampTolerance_s) return std::nullopt;
  return to_after < to_before ? after->T_map_base : (after - 1)->T_map_base;
}

Trajectory trajectory_from_rawlog(const std::string& path, std::string* source)
{
  RawlogStream stream(path);
  LogPoses poses;
  while (const auto object = stream.next()) poses.add(*object);
  std::string word;
  auto trajectory = poses.best(word);
  if (source) *source = word;
  return trajectory;
}

}  // namespace talus::io
