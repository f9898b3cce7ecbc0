#pragma once
#include <talus/site/site_files.h>

#include <limits>
#include <map>
#include <string>

namespace talus::site
{
/** What moved through a cell. */
struct TrafficCell
{
  /** How often something was there: after 3 s without a hit it is another visit. */
  int times = 0;
  /** How many of the scans that were kept hit it. */
  int scans = 0;
};

/** The cells of a tile where things moved, by their index in it. */
struct TrafficTile
{
  /** Those where nothing moved are not there. */
  std::map<int, TrafficCell> cells;
  /** The stamp of the last scan that is counted. */
  double until_s = -std::numeric_limits<double>::infinity();
};

/** Where things moved during a drive. */
using Traffic = std::map<TileKey, TrafficTile>;

/** Writes the bands `times` and `scans` as GeoTIFFs, whole or not at all, which are called as the
 * files of write_site_files(): "DIR/traffic.tif", DIR/traffic_floor_1.tif and so on. A file is as
 * large as the tiles where things moved, and NaN where nothing moved. Where nothing moved on a
 * floor or an island, it has no file. Throws std::runtime_error that names the file. */
void write_traffic_files(
    const std::string& path, const Traffic& traffic, Site& site, Far far = Far::Apart);

}  // namespace talus::site
