#pragma once
#include <talus/layers.h>
#include <talus/site/site.h>
#include <talus/site/site_geotiff.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace talus::site
{
/** Those of which something is known, in ascending order. */
std::vector<int> floors_of(const Site& site);

/** What is known of all floors; a guess from one side that no ray has proved is none. */
struct KnownCells
{
  std::array<std::size_t, kCellStates> by_state{};  //!< by CellState; of the unknown ones none
  double area_m2 = 0;  //!< of all of them, of all floors
};

/** Goes through all tiles, of which those on disk are read. */
KnownCells known_cells(Site& site);

/** Where islands (see islands.h) are written. */
enum class Far
{
  Apart,  //!< each into a file of its own
  Together  //!< all into one file, which may take long
};

/** The file of an island: "DIR/site_island_2.tif" for "DIR/site.tif"; of the first, that. */
std::string with_island(const std::string& path, std::size_t island);

/** The file of a floor: "DIR/site_floor_1.tif" for "DIR/site.tif"; of floor 0, that. */
std::string with_floor(const std::string& path, int floor);

/** Writes a whole site: write_site() of its first floor as `path`, "DIR/site.tif" say, of others as
 * DIR/site_floor_1.tif and so on; islands of a floor as files beside it, see with_island(); and the
 * ways of each floor, see way_file_of(). Beside `picture`, unless it is empty, write_site_picture()
 * of each in the same manner. Throws as they do. */
void write_site_files(
    const std::string& path, const std::string& picture, Site& site,
    const Progress& progress = Progress(), Far far = Far::Apart);

/** The warning of each file of an island that write_site_files() writes beside `path`. */
std::vector<std::string> texts_of_islands(const std::string& path, Site& site);

/** One file of a site. */
struct SitePart
{
  std::string path;  //!< of the GeoTIFF
  int floor;  //!< whose cells it has
};

/** All files of the site of which `path` is the first: that, as floor `floor`, its islands, and the
 * other floors with theirs. A file of another floor or an island is the first of its own islands.
 * Throws as read_site(), also where one is missing that was written with it. */
std::vector<SitePart> parts_of_site(const std::string& path, int floor);

/** Reads all parts_of_site(), the first as floor 0, moved by `shift`. Throws as read_site(). */
void read_site_files(const std::string& path, Site& site, const MapShift& shift = MapShift());

/** What a person puts into a report: the shaded ground of a floor in the colours of its
 * traversability, what stands on it, the ways driven, axes, scale, north and a legend. North is up
 * unless the page would be much emptier than with the site turned by up to 45 degrees. A PNG, whole
 * or not at all; a cell has a pixel or more up to a map of 3000 pixels on its long side and 6
 * million in all, and a pixel that stands for several cells has the worst of them. `part` ends the
 * title, which names the site and its floor. Throws std::runtime_error that names the file. */
void write_site_picture(
    const std::string& path, Site& site, int floor, const std::string& part = "");

/** Where the ways of a file of a site go: "DIR/site_way.gpkg" for "DIR/site.tif". */
std::string way_file_of(const std::string& site_file);

/** Writes the ways that were driven on a floor as a GeoPackage, whole or not at all: a layer `way`
 * with a line for each, and a layer `point` with about a point a metre and when the robot was
 * there, where that is known. It lies as the file of the site does. Throws std::runtime_error that
 * names the file. */
void write_way(const std::string& path, const Site& site, int floor);

}  // namespace talus::site
