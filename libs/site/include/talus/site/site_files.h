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

}  // namespace talus::site
