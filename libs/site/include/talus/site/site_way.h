#pragma once
#include <talus/site/site.h>

#include <string>

namespace talus::site
{
/** Where the ways of a file of a site go: "DIR/site_way.gpkg" for "DIR/site.tif". */
std::string way_file_of(const std::string& site_file);

/** Writes the ways that were driven on a floor as a GeoPackage, whole or not at all: a layer `way`
 * with a line for each, and a layer `point` with about a point a metre and when the robot was
 * there, where that is known. It lies as the file of the site does. Throws std::runtime_error that
 * names the file. */
void write_way(const std::string& path, const Site& site, int floor);

}  // namespace talus::site
