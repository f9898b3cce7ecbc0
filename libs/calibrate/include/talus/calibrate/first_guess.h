#pragma once
#include <talus/calibrate/pose_track.h>
#include <talus/calibrate/scan_set.h>

namespace talus::calibrate
{
/** The robot stands on the ground, so the ground around it is on average parallel to its base and
 * `base_height_m` below it. Turns the mounting in roll and pitch and lifts it until that holds for
 * the median frame: right to about a degree whatever was given. */
Vector level_mounting(const ScanSet& scans, const Vector& given);

}  // namespace talus::calibrate
