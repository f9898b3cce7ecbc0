#pragma once
#include "figures.h"

namespace talus::hints
{
/** Adds to `spreads_m` the deviation of the heights in each small cell of ground that one frame hit
 * often. `points`: all within reach, in the frame of the base. */
void note_spreads(const std::vector<Vec3>& points, const NearPlane& ground, Values& spreads_m);

}  // namespace talus::hints
