#pragma once
#include <talus/calibrate/pose_track.h>
#include <talus/calibrate/scan_set.h>

namespace talus::calibrate
{
/** The robot stands on the ground, so the ground around it is on average parallel to its base and
 * `base_height_m` below it. Turns the mounting in roll and pitch and lifts it until that holds for
 * the median frame: right to about a degree whatever was given. Throws std::runtime_error that says
 * what to do where the ground is above the sensor. */
Vector level_mounting(const ScanSet& scans, const Vector& given);

/** Throws std::runtime_error that says what to do where the ground leans by more than 10 degrees
 * under the robot in the median frame: what the log does not tell was given wrong. */
void require_level_ground(const ScanSet& scans, const Vector& v);

/** The same mounting with half a turn of roll more. */
Vector rolled_over(Vector v);

/** Whether the ground is where the robot stands if the sensor is rolled over, and not if it is
 * mounted as given. `rolled_scans` has the points that may be ground then. */
bool is_upside_down(const ScanSet& scans, const ScanSet& rolled_scans, const Vector& given);

}  // namespace talus::calibrate
