#pragma once
#include "options.h"

#include <functional>
#include <string>

namespace talus::calibrate
{
/** A log, ready to be calibrated. */
struct LoadedLog
{
  ScanSet scans;
  PoseTrack track;
  mrpt::poses::CPose3D T_base_sensor;  //!< as given; where it is upside down, rolled over
  bool is_rolled_over = false;
  std::string label, pose_source;
  std::size_t skipped = 0;  //!< scans without points or a stamp
};

/** Reads the scans of one sensor and the poses. `progress` gets the share read, 0..1. Throws
 * std::runtime_error that names the file, what is wrong and what to do. */
LoadedLog load_log(const AppOptions& options, const std::function<void(double)>& progress);

}  // namespace talus::calibrate
