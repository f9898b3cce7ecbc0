#pragma once
#include <talus/site/site.h>

#include <string>

namespace talus::site
{
/** Draws one floor of a site as a PNG for a report: hill-shaded ground, traversability over it, the
 * way driven, scale, north and legend. Throws std::runtime_error that names the file. */
void write_site_picture(const std::string& path, Site& site, int floor);

}  // namespace talus::site
