#pragma once
#include "corrected_poses.h"

#include <talus/import/scan_stream.h>

#include <optional>
#include <vector>

namespace talus::app
{
/** Finds where the odometry gets another position in the map. */
class JumpFinder
{
 public:
  /** `min_m`: by which that moves the base. */
  explicit JumpFinder(double min_m) : min_m_(min_m) {}

  /** The jumps just before these poses, which follow those of the last call. */
  std::vector<Jump> add(const std::vector<import::StreamPose>& poses);

 private:
  std::optional<Jump> jump_before(const import::StreamPose& pose);
  bool odometry_goes_on(const import::StreamPose& pose);

  double min_m_;
  std::optional<import::StreamPose> settled_;  //!< of a moment ago
  std::optional<io::Trajectory::Entry> odometry_;  //!< the last one, in its own frame
  double speed_mps_ = 0;  //!< of it
};

}  // namespace talus::app
