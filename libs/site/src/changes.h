#pragma once
#include "site_raster.h"

#include <talus/site/changes.h>

#include <memory>

namespace talus::site
{
/** Calls f(key, from, to) for each tile that both sites have on a floor; valid during the call. */
template <class F>
void for_each_common_tile(Site& from, Site& to, int floor, const F& f)
{
  const auto before = std::make_unique<Tile>();
  for (const TileKey& key : from.tiles.keys())
  {
    if (key.floor != floor) continue;
    *before = *from.tiles.find(key);  // which may be of the same store
    if (const Tile* after = to.tiles.find(key)) f(key, *before, *after);
  }
}

void write_changes_picture(
    const std::string& path, Site& from, Site& to, int floor, double step_m,
    const ChangeSums& sums);

}  // namespace talus::site
