#pragma once
#include "site_raster.h"

#include <talus/site/changes.h>

#include <functional>
#include <vector>

namespace talus::site
{
using OnTile = std::function<void(const TileKey&, const std::vector<CellChange>&)>;

/** Calls f for each tile that both sites have on a floor, with a change for each of its cells. An
 * edge that moved by one cell is none. */
void for_each_compared_tile(Site& from, Site& to, int floor, double step_m, const OnTile& f);

void write_changes_picture(
    const std::string& path, Site& from, Site& to, int floor, double step_m,
    const ChangeSums& sums);

}  // namespace talus::site
