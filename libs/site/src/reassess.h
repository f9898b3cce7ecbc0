#pragma once
#include <talus/parameters.h>
#include <talus/site/site.h>

#include <vector>

#include "seen_rays.h"

namespace talus::site
{
/** Judges cells of a tile that have changed, and those around them whose judgement rests on them:
 * they get the fills and the traversability of a map that has measured what the site has.
 * `changed`: indices in the tile. */
void reassess(
    Site& site, const Parameters& parameters, const TileKey& key, const std::vector<int>& changed);

/** Leaves guesses of a tile unjudged that no scan around it proves. A guess goes on level from the
 * ground on one side, and rays that passed over it may end far below it, often beyond the window.
 * So a ray has to end there, or close behind, at its height, and none lower. */
void forget_guesses(Site& site, const TileKey& key, const Scans& scans);

}  // namespace talus::site
