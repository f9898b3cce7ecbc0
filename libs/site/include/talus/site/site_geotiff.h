#pragma once
#include <talus/site/site.h>

#include <string>

namespace talus::site
{
/** Writes one floor of a site as a Cloud Optimized GeoTIFF, whole or not at all. Throws
 * std::runtime_error that names the file. */
void write_site(const std::string& path, Site& site, int floor);

/** Reads such a file as a floor of `site`, whose resolution must be that of the file. Throws
 * std::runtime_error that names the file and what is wrong. */
void read_site(const std::string& path, Site& site, int floor);

/** The resolution of such a file, to make a site for it. Throws as read_site(). */
double resolution_of_site(const std::string& path);

}  // namespace talus::site
