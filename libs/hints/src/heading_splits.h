#pragma once
#include <cstdint>
#include <vector>

#include "base_points.h"

namespace talus::hints
{
/** Two groups of frames that a robot took in different directions of travel: a bit for each frame.
 */
struct FrameSplit
{
  std::uint64_t one = 0, other = 0;
};

/** How far the headings of a drive lie apart [rad]. Up to 64 poses, in the order of time. */
double heading_span_rad(const std::vector<Pose>& poses);

/** The third of the frames that heads farthest to one side against that to the other; and the third
 * that turns most to one side, for each metre driven, against that to the other: who follows on the
 * robot's way swings out of its place there. */
std::vector<FrameSplit> splits_by_heading(const std::vector<Pose>& poses);

}  // namespace talus::hints
