#pragma once
#include "options.h"
#include "job.h"

#include <talus/frame.h>
#include <talus/io/trajectory.h>
#include <talus/mrpt/observation_points.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::app
{
/** Where the robot was when. */
class PoseSource
{
 public:
  /** Of one log, which messages call `name`, as the options say: none needed, a file, the file
   * beside the log, or the log itself; of an import those that it found. Throws std::runtime_error
   * that says what is missing and what to pass. */
  static PoseSource of_log(const SourceLog& log, const std::string& name, const Options& options);

  /** The base in the map frame, or nothing where the poses have a gap. */
  std::optional<mrpt::poses::CPose3D> base_at(double stamp_s) const;

  /** The poses of the sensor over the times of the points, for deskewing; empty when the points
   * have no times, when the robot stands still, or when the poses do not cover the scan. */
  std::vector<TimedPose> sensor_path(const SensorPoints& scan) const;

  /** In words. */
  const std::string& description() const { return description_; }

  /** Why none of the scans between two stamps has a pose, and what to do. */
  std::string why_no_pose(double first_stamp_s, double last_stamp_s) const;

 private:
  void load(const std::string& path);
  void level();
  void take_imported(const SourceLog& log, const std::string& name);
  void take_logged(const SourceLog& log, const std::string& name, const Options& options);

  bool robot_is_static_ = false;
  double max_gap_s_ = 0;
  io::Trajectory trajectory_;
  std::string description_;
};

}  // namespace talus::app
