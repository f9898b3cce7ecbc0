#pragma once
#include "seen_rays.h"

#include <talus/site/site.h>

namespace talus::site
{
/** Leaves guesses of a tile unjudged that no scan around it proves. A guess goes on level from the
 * ground on one side, and rays that passed over it may end far below it, often beyond the window.
 * So a ray has to end there, or close behind, at its height, and none lower. */
void forget_guesses(Site& site, const TileKey& key, const Scans& scans);

}  // namespace talus::site
