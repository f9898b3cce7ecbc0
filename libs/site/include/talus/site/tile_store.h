#pragma once
#include <talus/cell_record.h>
#include <talus/channels.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace talus::site
{
/** What a site keeps of a cell. */
struct SiteCell
{
  /** As the map had it last. */
  CellRecord cell;
  /** Whole seconds of the clock of the frames (Unix time where they have it), when the cell was in
   * the window last; 0: unknown cell, or a clock that starts at 0. */
  std::uint32_t seen_s = 0;

  /** Whether anything is. */
  bool known() const { return cell.state != 0; }
};

constexpr int kTileCells = 128;  //!< along each side

/** Which tile: its cells begin at (x, y) * kTileCells on the global grid of cells. Floors count
 * from 0, in the order in which they were driven first. */
struct TileKey
{
  /** Floor, column and row of the tile. */
  std::int32_t floor = 0, x = 0, y = 0;

  /** By floor, then row, then column. */
  bool operator<(const TileKey& o) const
  {
    return std::tie(floor, y, x) < std::tie(o.floor, o.y, o.x);
  }
  /** The same tile. */
  bool operator==(const TileKey& o) const { return floor == o.floor && x == o.x && y == o.y; }
};

/** Row by row: index = y * kTileCells + x. Unknown at first. */
struct Tile
{
  /** All, unknown or not. */
  std::array<SiteCell, static_cast<std::size_t>(kTileCells) * kTileCells> cells;
};

/** The values of channels of the cells of a tile. Unknown at first. */
struct ChannelTile
{
  /** In the order of Tile. */
  std::array<ChannelRecord, static_cast<std::size_t>(kTileCells) * kTileCells> cells;
};

/** Tiles of a site, as many as the budget allows in memory, the others on disk: those that were
 * asked for last stay. What is not needed for a while may be packed. Not thread safe. */
template <class T>
class StoreOf
{
 public:
  /** The minimum of tiles in memory, whatever the budget. */
  static constexpr std::size_t kMinInMemory = 4;

  /** `folder`: where a hidden folder is made for tiles that find no room, when the first does;
   * removed with the store. */
  StoreOf(std::size_t memory_bytes, std::string folder);
  ~StoreOf();
  StoreOf(const StoreOf&) = delete;
  StoreOf& operator=(const StoreOf&) = delete;

  /** Whether there is such a tile, wherever it is. */
  bool has(const TileKey& key) const;
  /** Null where there is none. Valid until the next call. Throws std::runtime_error where a tile on
   * disk cannot be read, or one cannot be written to make room. */
  const T* find(const TileKey& key);
  /** To be changed; made where there is none. Valid until the next call. Throws as find(). */
  T& at(const TileKey& key);
  /** Keeps one in a fifth of its memory or less, if it is in memory, until at() asks for it. find()
   * makes another copy each time, unless it was asked for the same one before. */
  void pack(const TileKey& key);
  /** Before all are read, more than once: unpacks them if the budget allows it for all. */
  void unpack_all();
  /** Those that at() gave out since the last call with this mark, ascending; with 0 all. */
  std::vector<TileKey> take_changed(std::uint64_t& mark) const;
  /** Forgets one, if there is such. */
  void erase(const TileKey& key);
  /** In ascending order, wherever they are. */
  std::vector<TileKey> keys() const;

  /** The others are on disk. */
  std::size_t tiles_in_memory() const;
  /** Bytes of memory. */
  struct Memory
  {
    std::size_t open = 0;  //!< for tiles that are not packed, in use or not
    std::size_t packed = 0;  //!< of packed tiles
  };
  /** What the tiles take now. */
  Memory memory() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** The cells of a site. */
using TileStore = StoreOf<Tile>;
/** The values of its channels, in the tiles where there are any. */
using ChannelStore = StoreOf<ChannelTile>;

/** The tile of a cell of the global grid, and its index there. */
inline std::int32_t tile_of(std::int64_t cell)
{
  return static_cast<std::int32_t>(
      cell >= 0 ? cell / kTileCells : -((-cell + kTileCells - 1) / kTileCells));
}
inline int index_in_tile(std::int64_t cell)
{
  return static_cast<int>(cell - static_cast<std::int64_t>(tile_of(cell)) * kTileCells);
}
/** The cell of the global grid at an index in a tile, along x or y. */
inline std::int64_t cell_of_tile(std::int32_t tile, std::int64_t index)
{
  return std::int64_t{tile} * kTileCells + index;
}
/** The middle of a cell of the global grid, along x or y. */
inline double middle_of_cell_m(std::int64_t cell, double resolution_m)
{
  return (static_cast<double>(cell) + 0.5) * resolution_m;
}

}  // namespace talus::site
