#include <talus/io/rawlog_reader.h>

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <algorithm>

#include "archive.h"

using mrpt::obs::CObservation;
using mrpt::poses::CPose3D;

namespace talus::io
{
namespace
{
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
