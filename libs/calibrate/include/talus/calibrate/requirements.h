#pragma once
#include <talus/calibrate/associate.h>

namespace talus::calibrate
{
/** Throws std::runtime_error that says what the log is short of when there are too few frames, or
 * the robot hardly moves while they are taken. */
void require_motion(const ScanSet& scans, const PoseTrack& track);

/** The same when too little of the ground is seen by several frames. */
void require_ground(const Association& a);

}  // namespace talus::calibrate
