#pragma once
#include <talus/formats/write.h>
#include <talus/live/messages.h>
#include <talus/site/tile_store.h>
#include <talus/cell_record.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace talus::app
{
constexpr formats::Occupancy kOccupancy{0.0, 0.5};  //!< as talus-export has it

/** The occupancy of one floor of a site, and of the window on it, in whole tiles. */
class WholeGrid
{
 public:
  /** What has changed, in cells of the global grid; none: no cell. */
  struct Area
  {
    std::int64_t min_x = INT64_MAX, min_y = INT64_MAX, end_x = INT64_MIN, end_y = INT64_MIN;
    bool empty() const { return min_x >= end_x; }
    void add(std::int64_t x, std::int64_t y, std::int64_t cells);
    Area grown(std::int64_t cells) const
    {
      return {min_x - cells, min_y - cells, end_x + cells, end_y + cells};
    }
  };

  /** `close_islands_m`: see formats::Occupancy. */
  explicit WholeGrid(double close_islands_m = 0) : close_islands_m_(close_islands_m) {}

  /** Looks at tiles that have changed; `window` has `cells`, islands and all, which count before
   * those of tiles where they are known. Another floor begins anew. */
  void update(
      site::TileStore& tiles, int floor, const Window& window,
      const std::vector<std::int8_t>& cells);

  /** Where cells are. */
  const Area& area() const { return area_; }
  /** What changed since the last call, and what that may close or open. cells() are of then. */
  Area take_changed();
  /** The cells of an area, without islands, see formats::Occupancy. */
  live::Grid cells(const Area& area, double resolution_m) const;

 private:
  live::Grid open_cells(const Area& area, double resolution_m) const;
  void close(const Area& area);
  using Cells = std::array<std::int8_t, site::Tile().cells.size()>;
  void read(site::TileStore& tiles, const site::TileKey& key);

  double close_islands_m_;
  std::optional<int> floor_;
  std::uint64_t changes_ = 0;  //!< of tiles, that it has looked at
  std::map<site::TileKey, Cells> tiles_, closed_;  //!< as they came, and without islands
  Window window_;
  std::vector<std::int8_t> window_cells_;
  Area area_, changed_;
};

}  // namespace talus::app
