#pragma once
#include <talus/parameters.h>
#include <talus/site/site.h>

#include <vector>

namespace talus::site
{
/** Judges cells of a tile that have changed, and those around them whose judgement rests on them:
 * they get the fills and the traversability of a map that has measured what the site has.
 * `changed`: places in the tile. */
void judge_anew(
    Site& site, const Parameters& parameters, const TileKey& key, const std::vector<int>& changed);

}  // namespace talus::site
