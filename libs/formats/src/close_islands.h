#pragma once
#include <talus/io/layer_stack.h>

#include <vector>

namespace talus::formats
{
/** The traversability of a map in which free cells that hang together, but in a rectangle of less
 * than `smallest_m` on both sides, are closed: no robot of that size gets there. They become what
 * is around them: blocked where they touch a blocked cell, else not judged. 0: as it is. */
std::vector<float> without_islands(const io::LayerStack& map, double blocked_at, double smallest_m);

}  // namespace talus::formats
