#pragma once
#include <talus/site/site.h>

#include <string>
#include <vector>

namespace talus::site
{
/** Tiles of a floor that lie far from all others of it. */
struct Island
{
  /** All that have a known cell, ascending. */
  std::vector<TileKey> tiles;
  /** The middle of one of them, map frame [m]. */
  double x_m = 0, y_m = 0;
};

/** What a floor falls into where one file of it would take long to write, because the rectangle
 * around all tiles is large and nearly empty: the island with the most tiles first. Empty: the
 * floor is written as one file. Reads tiles that are on disk where there are islands. Throws as
 * TileStore. */
std::vector<Island> islands_of(Site& site, int floor);

/** The runs of points of all ways on an island, or near it. */
std::vector<std::vector<WayPoint>> ways_on(const Island& island, const Site& site);

/** The warning of an island that gets a file of its own. */
std::string text_of_island(const Island& island, const std::string& file);

}  // namespace talus::site
