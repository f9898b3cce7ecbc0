#include "pose_source.h"

#include "../common/memory_limit.h"
#include "../common/log_name.h"
#include "../common/crash_context.h"

#include <talus/io/rawlog_reader.h>
#include <talus/number_text.h>

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
std::string seconds(double s)
{
  char text[40];
  std::snprintf(text, sizeof text, "%.3f", s);
  return text;
}

}  // namespace

PoseSource PoseSource::of_log(const SourceLog& log, const std::string& name, const Options& options)
{
  PoseSource source;
  source.max_gap_s_ = options.max_gap_s;
  source.robot_is_static_ = options.robot_is_static;
  if (options.robot_is_static)
    source.description_ = "static";
  else if (log.is_imported)
    source.take_imported(log, name);
  else
    source.take_logged(log, name, options);
  if (options.is_levelled && !source.robot_is_static_) source.level();
  return source;
}

/** `path` may lie in a hidden folder: the description says where its poses come from. */
void PoseSource::load(const std::string& path)
{
  trajectory_ = guarded(
      description_, kCompareWithSource, [&] { return io::Trajectory::load(path); },
      memory_for_log(path));
  if (trajectory_.empty())
    throw std::runtime_error(
        description_ + ": holds no poses; a trajectory has lines 't x y z qx qy qz qw'");
}

void PoseSource::take_imported(const SourceLog& log, const std::string& name)
{
  description_ = log.poses;
  if (!log.poses.empty()) return load(trajectory_beside(log.path));
  if (log.scans != 1)
    throw std::runtime_error(
        name +
        ": has no poses of the robot. Pass --trajectory FILE, or say --static if the robot did not "
        "move");
  robot_is_static_ = true;
  description_ = "static, as a single scan without a pose";
}

void PoseSource::take_logged(const SourceLog& log, const std::string& name, const Options& options)
{
  const std::string beside = trajectory_beside(log.path);
  std::error_code ec;
  if (!options.trajectory.empty() || fs::exists(beside, ec))
  {
    description_ = options.trajectory.empty() ? beside : options.trajectory;
    return load(description_);
  }
  trajectory_ = guarded(
      name, kLookAtLog, [&] { return io::trajectory_from_rawlog(log.path, &description_); },
      memory_for_log(log.path));
  description_ += " of the log";
  if (trajectory_.empty())
    throw std::runtime_error(
        name +
        ": holds no poses of the robot (robot poses, odometry or actions). Pass "
        "--trajectory FILE, put them into " +
        beside + ", or say --static if the robot did not move");
}

void PoseSource::level()
{
  double turned_rad = 0;
  trajectory_ = trajectory_.levelled(turned_rad);
  description_ += ", levelled by " + fixed_text(turned_rad * 180 / M_PI, 1) + " degrees";
}

std::optional<mrpt::poses::CPose3D> PoseSource::base_at(double stamp_s) const
{
  if (robot_is_static_) return mrpt::poses::CPose3D();
  return trajectory_.at(stamp_s, max_gap_s_);
}

std::vector<TimedPose> PoseSource::sensor_path(const SensorPoints& scan) const
{
  if (robot_is_static_) return {};
  return talus::sensor_path(scan, [this](double stamp_s) { return base_at(stamp_s); });
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
