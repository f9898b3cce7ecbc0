#pragma once
#include <talus/site/site.h>

#include <string>

namespace talus::site
{
/** What a person puts into a report: the shaded ground of a floor in the colours of its
 * traversability, what stands on it, the ways driven, axes, scale, north and a legend. North is up
 * unless the page would be much emptier than with the site turned by up to 45 degrees. A PNG, whole
 * or not at all; a cell has a pixel or more up to a map of 3000 pixels on its long side and 6
 * million in all, and a pixel that stands for several cells has the worst of them. `title`: a line
 * above, empty: one is made. Throws std::runtime_error that names the file. */
void write_site_picture(
    const std::string& path, Site& site, int floor, const std::string& title = "");

}  // namespace talus::site
