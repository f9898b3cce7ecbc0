#pragma once
#include <talus/site/traffic_map.h>

#include <map>
#include <vector>

namespace talus::site
{
/** How fast things moved over the cells of some tiles of one floor [m/s], by the place in the tile;
 * cells where it is unknown are not there. What a scan hit is parted into things, and each thing is
 * followed from scan to scan. It has a speed where its place goes along a line, at least in three
 * scans. A cell has the median of the things that were there. */
std::map<TileKey, std::map<int, float>> speeds_of(
    const Traffic& traffic, const std::vector<TileKey>& tiles, double resolution_m);

}  // namespace talus::site
