#pragma once
#include <talus/formats/write.h>

#include <cstdint>
#include <vector>

namespace talus::formats
{
/** What a cell is to a planner. */
enum class Kind : std::uint8_t
{
  Unknown,
  Free,
  Blocked
};

/** Of each cell. Free cells that hang together are closed where a square of
 * Occupancy::close_islands_m holds them: no robot of that size gets there. They become what is
 * around them, blocked where they touch a blocked cell, else unknown. */
std::vector<Kind> kinds_of(const io::LayerStack& map, const Occupancy& o);

}  // namespace talus::formats
