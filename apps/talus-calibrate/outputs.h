#pragma once
#include <talus/calibrate/calibrate.h>

#include <functional>
#include <string>

#include "options.h"

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

/** Lines for the map's INI file: the noise. */
std::string calibration_ini(const AppOptions& options, const LoadedLog& log, const Result& result);

/** The mounting as --mount takes it. */
std::string mounting_text(const Result& result);

/** The mounting as `rawlog-edit --sensors-pose` reads it. */
std::string sensors_pose_ini(const LoadedLog& log, const Result& result);

/** Everything, for programs. Angles in degrees, the rest in metres and seconds. */
std::string calibration_json(const AppOptions& options, const LoadedLog& log, const Result& result);

/** Before and after: thickness of the ground and how high or low it is seen, by range, of the
 * held-out frames. Writes a PNG; throws std::runtime_error naming the file. */
void write_picture(const std::string& path, const std::string& title, const Result& result);

/** What is printed when all is done: the parameters, the noise, what the held-out frames say. */
std::string console_report(const AppOptions& options, const LoadedLog& log, const Result& result);

}  // namespace talus::calibrate
