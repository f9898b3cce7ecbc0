#pragma once
#include <talus/site/site.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::site
{
/** A fix of a satellite receiver and where its antenna then was in the map frame. */
struct GpsFix
{
  /** WGS 84; the height above its ellipsoid. */
  double latitude_deg, longitude_deg, altitude_m;
  /** Of the antenna, map frame. */
  double x_m, y_m, z_m;
};

/** The origin that places the fixes best, all alike: a turn about the vertical and a shift. Of
 * positions that all lie within 10 m the heading is unknown: then it is 0, and the first fix
 * counts. `warning` gets a sentence where there is something to doubt. Nothing without fixes. */
std::optional<GeoOrigin> origin_from_fixes(const std::vector<GpsFix>& fixes, std::string& warning);

}  // namespace talus::site
