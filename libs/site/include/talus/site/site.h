#pragma once
#include <talus/io/geo_origin.h>
#include <talus/site/tile_store.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace talus::site
{
/** Where the origin of a map frame is on Earth. */
using GeoOrigin = io::GeoOrigin;

/** A point of the path that was driven, map frame. */
struct WayPoint
{
  /** Of the base [m]. */
  float x_m, y_m, z_m;
  /** See TileKey. */
  std::int32_t floor;
  /** When, by the clock of the frames; NaN where it is not known. */
  double stamp_s = NAN;
};

/** All that was seen, of any size: one map of a drive, or of several. */
struct Site
{
  /** An empty one. The other arguments as of TileStore. */
  Site(double resolution, std::size_t memory_bytes, const std::string& folder)
      : resolution_m(resolution), tiles(memory_bytes, folder), channel_tiles(memory_bytes, folder)
  {
  }

  /** Of the log or the maps that it is of, for titles; may be empty. */
  std::string name;
  /** Side of a cell [m]. */
  double resolution_m;
  /** Nothing where it is not known. */
  std::optional<GeoOrigin> origin;
  /** The cells. */
  TileStore tiles;
  /** What points brought besides their position. */
  std::vector<Channel> channels;
  /** Their values, by layer of the channels; no tile where there are none. */
  ChannelStore channel_tiles;
  /** Each drive's way, about a point per metre. */
  std::vector<std::vector<WayPoint>> ways;
};

}  // namespace talus::site
