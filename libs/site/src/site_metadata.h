#pragma once
#include <talus/site/site.h>
#include <gdal_support.h>
#include <talus/site/site_geotiff.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

// What a file of a site says besides its cells.
namespace talus::site
{
using Ways = std::vector<std::vector<WayPoint>>;

/// @name Items of the metadata
/// @{
constexpr const char* kFloorItem = "TALUS_FLOOR";
constexpr const char* kFloorsItem = "TALUS_FLOORS";  //!< all of the site; none where it is the only
constexpr const char* kObjectTopsItem = "TALUS_ISLANDS";  //!< other files of the floor; none: 0
constexpr const char* kResolutionItem = "TALUS_RESOLUTION_M";
constexpr const char* kMinCellXItem = "TALUS_MIN_CELL_X";  //!< of the lower left cell
constexpr const char* kMinCellYItem = "TALUS_MIN_CELL_Y";
constexpr const char* kSeenItem = "TALUS_SEEN_S";  //!< when the newest cell was seen
constexpr const char* kWaysItem = "TALUS_WAYS";  //!< none where there are no ways
constexpr const char* kSumsItem = "TALUS_TILE_SUMS";  //!< see TileSums; none: not checked
constexpr const char* kChannelsItem = "TALUS_CHANNELS";  //!< "intensity:mean"; none: no channels
/// @}

/** The runs of points on one floor. */
Ways on_floor(const Ways& ways, int floor);

/** The points of one floor in whole centimetres, "x y z t, x y z t; x y z t, ...", evenly thinned
 * to about 20,000; t: seconds, left out where it is not known. A way that leaves the floor and
 * comes back becomes two. In an order of their own, each once: whoever drove them first. */
std::string text_of_ways(const Ways& ways, int floor);
/** And back. Nothing where the text is none of ways. */
std::optional<Ways> ways_from(const std::string& text, int floor);

/** "0 1 2" */
std::string text_of_floors(const std::vector<int>& floors);
/** And back. Nothing where the text is none of floors. */
std::optional<std::vector<int>> floors_from(const std::string& text);

/** The TileSum of each tile, by its column and row. */
using TileSums = std::map<std::pair<std::int32_t, std::int32_t>, std::uint32_t>;

/** "x y sum;x y sum" */
std::string text_of_sums(const TileSums& sums);
/** And back. Nothing where the text is none of sums. */
std::optional<TileSums> sums_from(const std::string& text);

using io::crs_of;
using io::kOriginItem;
using io::origin_from;
using io::text_of_origin;
using io::transform_of;

/** What a file has of a site, and which others are written with it. */
struct FileOfFloor
{
  int floor;
  std::vector<int> floors;  //!< of the site
  std::size_t islands;  //!< of the floor beside this file
};

/** As write_site(), of a site that has no tiles but those of the file. */
void write_site_file(
    const std::string& path, Site& site, const FileOfFloor& file, const Progress& progress);

}  // namespace talus::site
