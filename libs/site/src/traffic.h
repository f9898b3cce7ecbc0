#pragma once
#include <talus/parameters.h>
#include <talus/site/site.h>
#include <talus/site/traffic_map.h>

#include <map>
#include <set>
#include <vector>

#include "surroundings.h"
#include "seen_rays.h"

namespace talus::site
{
/** Which scans hit what was cleared, in the tiles near the robot, by the index in a tile. */
using Trails = std::map<TileKey, std::map<int, HitScans>>;

/** Clears what moved from a tile. Of the scans around a cell, some hit what stands there, and
 * others have rays that passed through the same heights without a hit, before and after, inside of
 * the window and beyond it. Where so much more passed than was hit, in a square around the cell, it
 * was traffic; and what stands beside that and was hit by the same scans alone, or those next to
 * them, is of the same thing. `traffic`, unless it is null: counts where things moved, whether
 * anything of them is left or not. Returns the tiles beside it into which what has moved goes on.
 */
std::set<TileKey> clear_traffic(
    Site& site, const Parameters& parameters, const TileKey& key, const Scans& scans,
    Trails& trails, Traffic* traffic);

}  // namespace talus::site
