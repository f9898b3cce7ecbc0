#pragma once
#include "seen_rays.h"

#include <talus/parameters.h>
#include <talus/site/site.h>
#include <talus/site/traffic_map.h>

namespace talus::site
{
/** Clears what moved from a tile. Of the scans around a cell, some hit what stands there, and
 * others have rays that passed through the same heights without a hit, before and after, inside of
 * the window and beyond it. Where so much more passed than was hit, in a square around the cell, it
 * was traffic. */
void clear_traffic(
    Site& site, const Parameters& parameters, const TileKey& key, const Scans& scans);

/** Counts where things moved in a tile, whether anything of them is left in the site or not. Before
 * clear_traffic(). */
void note_traffic(Site& site, const TileKey& key, const Scans& scans, Traffic& traffic);

}  // namespace talus::site
