#pragma once
#include "seen_rays.h"

#include <talus/site/site.h>

namespace talus::site
{
/** Leaves guesses of a tile unjudged that the scans around it contradict. A guess goes on level
 * from the ground on one side. Rays that pass over it end somewhere behind it, often beyond the
 * window: where that is lower than gentle ground would be, the ground may drop there. */
void forget_guesses(Site& site, const TileKey& key, const Scans& scans);

}  // namespace talus::site
