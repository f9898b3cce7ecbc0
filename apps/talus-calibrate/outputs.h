#pragma once
#include "load_log.h"

#include <string>

namespace talus::calibrate
{
/** Lines for the map's INI file: the noise. */
std::string calibration_ini(const AppOptions& options, const LoadedLog& log, const Result& result);

/** The mounting as --mount takes it. */
std::string mounting_text(const Result& result);

/** The mounting as `rawlog-edit --sensors-pose` reads it. */
std::string sensors_pose_ini(const LoadedLog& log, const Result& result);

/** Everything, for programs. Angles in degrees, the rest in metres and seconds. */
std::string calibration_json(const AppOptions& options, const LoadedLog& log, const Result& result);

}  // namespace talus::calibrate
