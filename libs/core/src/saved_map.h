#pragma once
#include "backend.h"
#include "window_tracker.h"

namespace talus
{
/** The state of a map between two frames, as ElevationMapper::save() keeps it. */
struct SavedMap
{
  WindowTracker tracker;
  float reference_z_m = 0;  //!< reference of the heights of the last frame
  MapBytes map;  //!< empty before the first frame
};

std::vector<std::uint8_t> bytes_of(const SavedMap& saved, const Parameters& p);

/** Throws std::invalid_argument if the bytes are no state of a map with these parameters. */
SavedMap saved_map_from(const std::vector<std::uint8_t>& bytes, const Parameters& p);

}  // namespace talus
