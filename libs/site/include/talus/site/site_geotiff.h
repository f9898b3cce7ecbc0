#pragma once
#include <talus/io/geotiff.h>
#include <talus/site/map_shift.h>
#include <talus/site/site.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace talus::site
{
/** Told how much is done, 0..1. */
using Progress = std::function<void(double)>;

/** Writes one floor of a site as a Cloud Optimized GeoTIFF, whole or not at all: the same bytes for
 * the same site. Throws std::runtime_error that names the file, also where the floor has no known
 * cell. */
void write_site(
    const std::string& path, Site& site, int floor, const Progress& progress = Progress());

/** Reads such a file as a floor of `site`, whose resolution must be that of the file. Its origin
 * must be the same, too; a site without tiles takes it over. The map is moved by `shift` first.
 * Throws std::runtime_error that names the file and what is wrong. */
void read_site(const std::string& path, Site& site, int floor, const MapShift& shift = MapShift());

/** The resolution of such a file, to make a site for it. Throws as read_site(). */
double resolution_of_site(const std::string& path);
/** Which floor it was written as. Throws as read_site(). */
int floor_of_site(const std::string& path);
/** All floors that were written with it; empty where it is the only one. Throws as read_site(). */
std::vector<int> floors_of_site(const std::string& path);
/** How many islands of its floor were written beside it. Throws as read_site(). */
std::size_t islands_of_site(const std::string& path);
/** The ways that were driven on such a file, map frame; none in a file of another kind. */
std::vector<std::vector<WayPoint>> ways_of_site(const io::GeotiffFile& file);
/** When its newest cell was seen, whole seconds since 1970. Throws as read_site(). */
std::uint32_t newest_of_site(const std::string& path);

}  // namespace talus::site
