#include "pose_source.h"

#include "../common/log_name.h"
#include "../common/suspect.h"

#include <talus/io/rawlog_reader.h>
#include <talus/mrpt/pose_from.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
constexpr double kPathStep_s = 0.01;  // a robot that turns at 1 rad/s turns 0.6 degrees in it
constexpr int kMostPathPoses = 64;

std::string seconds(double s)
{
  char text[40];
  std::snprintf(text, sizeof text, "%.3f", s);
  return text;
}

}  // namespace

PoseSource PoseSource::of_log(const std::string& log, const Options& options)
{
  PoseSource source;
  source.max_gap_s_ = options.max_gap_s;
  const std::string beside = trajectory_beside(log);
  std::error_code ec;
  if (options.robot_is_static)
  {
    source.robot_is_static_ = true;
    source.description_ = "static";
  }
  else if (!options.trajectory.empty() || fs::exists(beside, ec))
  {
    source.description_ = options.trajectory.empty() ? beside : options.trajectory;
    source.trajectory_ = guarded(
        source.description_, kCompareWithSource,
        [&] { return io::Trajectory::load(source.description_); });
    if (source.trajectory_.empty())
      throw std::runtime_error(
          source.description_ + ": holds no poses; a trajectory has lines 't x y z qx qy qz qw'");
  }
  else
  {
    source.trajectory_ = guarded(
        log, kLookAtLog, [&] { return io::trajectory_from_rawlog(log, &source.description_); });
    source.description_ += " of the log";
    if (source.trajectory_.empty())
      throw std::runtime_error(
          log +
          ": holds no poses of the robot (robot poses, odometry or actions). Pass "
          "--trajectory FILE, put them into " +
          beside + ", or say --static if the robot did not move");
  }
  return source;
}

std::optional<mrpt::poses::CPose3D> PoseSource::base_at(double stamp_s) const
{
  if (robot_is_static_) return mrpt::poses::CPose3D();
  return trajectory_.at(stamp_s, max_gap_s_);
}

std::vector<TimedPose> PoseSource::sensor_path(const SensorPoints& scan) const
{
  if (robot_is_static_ || scan.time_s.empty()) return {};
  float first = HUGE_VALF, last = -HUGE_VALF;
  for (const float t : scan.time_s)
    if (std::isfinite(t))
    {
      first = std::min(first, t);
      last = std::max(last, t);
    }
  const double span_s = static_cast<double>(last) - first;
  if (!(span_s > 0)) return {};

  const int steps =
      static_cast<int>(std::clamp(std::ceil(span_s / kPathStep_s), 1.0, kMostPathPoses - 1.0));
  std::vector<TimedPose> path;
  for (int i = 0; i <= steps; ++i)
  {
    const double t = first + span_s * i / steps;
    if (const auto T_map_base = base_at(scan.stamp_s + t))
      path.push_back({t, pose_from(*T_map_base + scan.T_base_sensor)});
  }
  if (path.size() < 2) path.clear();
  return path;
}

std::string PoseSource::why_no_pose(double first_stamp_s, double last_stamp_s) const
{
  const double from = trajectory_.empty() ? 0 : trajectory_.entries().front().time_s;
  const double to = trajectory_.empty() ? 0 : trajectory_.entries().back().time_s;
  std::string text = "its scans are from " + seconds(first_stamp_s) + " to " +
                     seconds(last_stamp_s) + " s, the poses (" + description_ + ") from " +
                     seconds(from) + " to " + seconds(to) + " s. ";
  if (last_stamp_s < from || first_stamp_s > to)
    return text + "They do not overlap: is it the trajectory of another log, or of another clock?";
  return text + "The poses around each scan are more than " + seconds(max_gap_s_) +
         " s apart: allow more with --max-gap";
}

}  // namespace talus::app
