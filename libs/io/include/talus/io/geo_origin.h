#pragma once

namespace talus::io
{
/** Where the origin of a map frame is on Earth (WGS 84). */
struct GeoOrigin
{
  /** WGS 84; the height above its ellipsoid. */
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
  /** Of the map's x axis, counter-clockwise from east: 0 where x points east, 90 where it points
   * north. */
  double heading_deg = 0;
};

}  // namespace talus::io
