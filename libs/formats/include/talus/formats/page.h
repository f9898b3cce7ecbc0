#pragma once
#include <talus/io/geo_origin.h>
#include <talus/io/layer_stack.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace talus::formats
{
/** A place of a way [m, map frame]. */
struct PagePoint
{
  double x_m, y_m, z_m;
};

/** A map that is read part by part, so that a large one finds room. */
struct PageMap
{
  /** Where it lies, and the names of its layers, which themselves may be missing. */
  io::LayerStack place;
  /** `cells_x` by `cells_y` cells from cell (x, y) on, of these layers where they are there. */
  std::function<io::LayerStack(
      int x, int y, int cells_x, int cells_y, const std::vector<std::string>& names)>
      read;
};

/** Of a map in memory, which has to stay. Throws std::runtime_error where it is not sound. */
PageMap page_map(const io::LayerStack& map);

/** What a page shows beside the map. */
struct PageOptions
{
  std::string title;  //!< in UTF-8
  std::string date;  //!< when its newest cell was seen; may be empty
  std::vector<std::vector<PagePoint>> ways;  //!< that were driven
  std::optional<io::GeoOrigin> origin;  //!< where the map is on Earth
  const PageMap* changes = nullptr;  //!< bands `kind` and `change_m`, of the same cells' size
  std::size_t max_bytes = std::size_t{30} << 20;  //!< cells are joined until the page is smaller
};

/** Of the names of bands those of channels (see channel_layer_names()): NAME and NAME_standing,
 * where both are there and NAME is one that a channel may have. */
std::vector<std::string> channel_bands(const std::vector<std::string>& names);

/** Throws where write_page() would for want of the package. */
void require_leaflet();

/** One file of HTML that any browser opens without a network: layers to switch (also those of
 * channels), zoom, the values under the pointer or the finger, and distance and height profile
 * between two places; as good on a phone. It brings Leaflet and its licence along, which Debian's
 * libjs-leaflet has. Throws std::runtime_error that names the file, the layer or the package which
 * is missing. */
void write_page(
    const std::string& path, const PageMap& map, const PageOptions& options = PageOptions());

/** Of the page of a map that is not complete yet. */
struct LivePage
{
  std::string title;  //!< in UTF-8
  std::string run;  //!< of its maker: pages of another one load themselves anew
  double resolution_m = 0;  //!< of all its cells
  int tile_cells = 0;  //!< side of its tiles
};

/** The page of write_page() without cells: they come from where it comes from, as events (of
 * EventSource) from `events`, and it draws what comes. These are
 *   begin  {"run", "map"}: all that is shown of another map is forgotten,
 *   tile   live_cells() of a tile of the grid through the origin,
 *   path   {"way", "part", "points"}: a part of a path, points [x, y],
 *   now    its age [s] in a first line, then {"x_m", "y_m", "z_m", "yaw_rad", "frames",
 *          "driven_m", "cells"}: the robot, and live_cells() of its window,
 *   idle   the age of the last `now`, once a second where none comes.
 * Throws std::runtime_error as require_leaflet(). */
std::string live_page(const LivePage& page);

/** From how far other cells change how those of a tile look: so wide a margin has a tile. */
int live_margin_cells(double resolution_m);

/** Cells of such a page, without `margin_cells` on each side of `map`, as JSON; "" where none is
 * known. (column, row): of a tile; of a window the first column and the northernmost row of its
 * cells, rows counted downwards from the origin. */
std::string live_cells(const io::LayerStack& map, int margin_cells, int column, int row);

}  // namespace talus::formats
