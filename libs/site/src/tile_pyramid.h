#pragma once
#include <talus/site/site.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace talus::site
{
/** One floor of a site as an image of whole tiles, north up, and its overviews: each half as large
 * as the one before, its cells the worst that is known of four. Tile (x, y) is counted from the
 * upper left corner. */
class TilePyramid
{
 public:
  /** Takes the tiles that have a known cell. Overviews are made until one is at most
   * `largest_cells` wide and high; those that find no room in memory go to `folder`. Throws as
   * TileStore. */
  TilePyramid(Site& site, int floor, int largest_cells, const std::string& folder);

  bool empty() const { return levels_.empty(); }
  int levels() const { return static_cast<int>(levels_.size()); }
  std::int64_t width_cells(int level) const { return (width_cells_ + (1LL << level) - 1) >> level; }
  std::int64_t height_cells(int level) const
  {
    return (height_cells_ + (1LL << level) - 1) >> level;
  }
  /** The lower left corner on the global grid of cells. */
  std::int64_t min_cell_x() const { return min_cell_x_; }
  std::int64_t min_cell_y() const { return min_cell_y_; }
  std::uint32_t newest_s() const { return newest_s_; }
  /** Whether there is a tile from (x0, y0) to (x1, y1), and whether all are there. */
  struct Coverage
  {
    bool any, all;
  };
  Coverage coverage(int level, int x0, int y0, int x1, int y1) const;

  /** Null where there is none. Valid until the next call. Throws as TileStore. */
  const Tile* tile(int level, int x, int y);
  /** The values of channels of such a tile; null where it has none. Valid as that. */
  const ChannelTile* values(int level, int x, int y);
  /** f(key, tile, values or null) for those of level 0. Throws as TileStore. */
  void for_each_tile(const std::function<void(const TileKey&, const Tile&, const ChannelTile*)>& f);
  /** Which row of such a tile is the `row`-th from the north. */
  static int row_of(int level, int row) { return level == 0 ? kTileCells - 1 - row : row; }

 private:
  struct TileIndex
  {
    std::int32_t y, x;
    bool operator<(const TileIndex& o) const { return y != o.y ? y < o.y : x < o.x; }
    bool operator==(const TileIndex& o) const { return y == o.y && x == o.x; }
  };
  void take_known_tiles();
  void add_level();
  void add_to_level(int level, const TileIndex& below);

  TileStore& tiles_;
  ChannelStore& values_;
  TileStore overviews_;  //!< a floor for each level
  ChannelStore overview_values_;
  int floor_;
  std::int32_t min_tile_x_ = 0, max_tile_y_ = 0;
  std::int64_t min_cell_x_ = 0, min_cell_y_ = 0, width_cells_ = 0, height_cells_ = 0;
  std::uint32_t newest_s_ = 0;
  std::vector<std::vector<TileIndex>> levels_;  //!< the tiles of each, ascending
};

}  // namespace talus::site
