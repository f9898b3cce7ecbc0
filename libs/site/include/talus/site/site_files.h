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

/** Writes write_site() and write_site_picture() of each floor: floor 0 as `path`, "DIR/site.tif"
 * say, and as DIR/site.png, others as DIR/site_floor_1.tif and so on. Throws as they do. */
void write_site_files(const std::string& path, Site& site, const Progress& progress = Progress());

/** Reads such a file as floor 0, and the other floors from the files beside it. Throws as
 * read_site(), also where one is missing that was written with it. */
void read_site_files(const std::string& path, Site& site);

}  // namespace talus::site
