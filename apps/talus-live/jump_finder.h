#pragma once
#include "corrected_poses.h"

#include <talus/import/scan_stream.h>

#include <optional>

namespace talus::app
{
/** Finds where the odometry gets another position in the map. */
class JumpFinder
{
 public:
  /** `min_m`: by which that moves the base. */
  explicit JumpFinder(double min_m) : min_m_(min_m) {}

  /** The jump just before this pose. */
  std::optional<Jump> add(const import::StreamPose& pose);

 private:
  bool odometry_goes_on(const import::StreamPose& pose);

  double min_m_;
  std::optional<import::StreamPose> settled_;  //!< of a moment ago
  std::optional<io::Trajectory::Entry> odometry_;  //!< the last one, in its own frame
  double speed_mps_ = 0;  //!< of it
};

}  // namespace talus::app
