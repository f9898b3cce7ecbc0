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

/** What is known of all floors. */
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

/** Writes write_site() of a floor as `path`, and write_site_picture() as `picture` unless it is
 * empty; islands of the floor as files beside them, see with_island(). The ways of the floor become
 * one write_way() beside `path`, see way_file_of(). Throws as they do. */
void write_floor_files(
    const std::string& path, const std::string& picture, Site& site, int floor, Far far,
    const Progress& progress = Progress());

/** write_floor_files() of each floor: floor 0 as `path`, "DIR/site.tif" say, and as DIR/site.png,
 * others as DIR/site_floor_1.tif and so on. */
void write_site_files(
    const std::string& path, Site& site, const Progress& progress = Progress(),
    Far far = Far::Apart);

/** The file of a floor that write_site_files() writes. */
std::string with_floor(const std::string& path, int floor);

/** Reads such a file as floor 0, its islands, and the other floors from the files beside it. Throws
 * as read_site(), also where one is missing that was written with it. */
void read_site_files(const std::string& path, Site& site);

/** What a person puts into a report: the shaded ground of a floor in the colours of its
 * traversability, what stands on it, the ways driven, axes, scale, north and a legend. North is up
 * unless the page would be much emptier than with the site turned by up to 45 degrees. A PNG, whole
 * or not at all; a cell has a pixel or more up to a map of 3000 pixels on its long side and 6
 * million in all, and a pixel that stands for several cells has the worst of them. `title`: a line
 * above, empty: one is made. Throws std::runtime_error that names the file. */
void write_site_picture(
    const std::string& path, Site& site, int floor, const std::string& title = "");

/** Where the ways of a file of a site go: "DIR/site_way.gpkg" for "DIR/site.tif". */
std::string way_file_of(const std::string& site_file);

/** Writes the ways that were driven on a floor as a GeoPackage, whole or not at all: a layer `way`
 * with a line for each, and a layer `point` with about a point a metre and when the robot was
 * there, where that is known. It lies as the file of the site does. Throws std::runtime_error that
 * names the file. */
void write_way(const std::string& path, const Site& site, int floor);

}  // namespace talus::site
