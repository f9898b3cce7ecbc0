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

/** Reads it to its end; throws as read_site(), also where a cell is not as it was written. */
void require_whole(const std::string& path);

/** What such a file says beside its cells. */
struct SiteInfo
{
  double resolution_m = 0;  //!< side of a cell
  int floor = 0;  //!< which it was written as
  std::vector<int> floors;  //!< all that were written with it; empty where it is the only one
  std::size_t islands = 0;  //!< of its floor, that were written beside it
  std::uint32_t newest_s = 0;  //!< when its newest cell was seen, whole seconds since 1970
};

/** Throws as read_site(). */
SiteInfo info_of_site(const std::string& path);
/** Whether a file is such a one as it was written: no map of a window, nor a part cut out. */
bool is_site(const io::GeotiffFile& file);
/** The paths that were driven on such a file, map frame; none in a file of another kind. */
std::vector<std::vector<WayPoint>> ways_of_site(const io::GeotiffFile& file);

}  // namespace talus::site
