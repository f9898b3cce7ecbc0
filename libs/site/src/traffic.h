#pragma once
#include <talus/parameters.h>
#include <talus/site/site.h>
#include <talus/site/traffic_map.h>

#include <map>
#include <set>
#include <vector>

#include "column.h"
#include "seen_rays.h"

namespace talus::site
{
/** Which scans hit what was cleared, in the tiles near the robot, by the place in a tile. */
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

/** How fast things moved over the cells of some tiles of one floor [m/s], by the place in the tile;
 * cells where it is unknown are not there. What a scan hit is parted into things, and each thing is
 * followed from scan to scan. It has a speed where its place goes along a line, at least in three
 * scans. A cell has the median of the things that were there. */
std::map<TileKey, std::map<int, float>> speeds_of(
    const Traffic& traffic, const std::vector<TileKey>& tiles, double resolution_m);

}  // namespace talus::site
