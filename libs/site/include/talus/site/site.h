#pragma once
#include <talus/site/tile_store.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace talus::site
{
/** Where the origin of a map frame is on Earth (WGS 84). */
struct GeoOrigin
{
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
  /** Of the map's x axis, counter-clockwise from east: 0 where x points east, 90 where it points
   * north. */
  double heading_deg = 0;
};

/** A place of the way that was driven, map frame. */
struct WayPoint
{
  float x_m, y_m, z_m;
  std::int32_t floor;
};

/** All that was seen, of any size: one map of a drive, or of several. */
struct Site
{
  Site(double resolution, std::size_t memory_bytes, std::string folder)
      : resolution_m(resolution), tiles(memory_bytes, std::move(folder))
  {
  }

  double resolution_m;
  std::optional<GeoOrigin> origin;
  TileStore tiles;
  /** Each drive's way, about a point per metre. */
  std::vector<std::vector<WayPoint>> ways;
};

}  // namespace talus::site
