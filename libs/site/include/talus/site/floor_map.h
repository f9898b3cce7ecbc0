#pragma once
#include <talus/live_map.h>
#include <talus/site/site.h>

#include <cstdint>
#include <map>

namespace talus::site
{
/** From the first to the last known cell. */
struct CellBox
{
  /** Of the global grid; min above max: none. */
  std::int64_t min_x = INT64_MAX, min_y = INT64_MAX, max_x = INT64_MIN, max_y = INT64_MIN;

  /** Whether it holds no cell. */
  bool empty() const { return min_x > max_x; }
  /** Grows to hold the cell. */
  void add(std::int64_t x, std::int64_t y);
  /** Grows to hold the other. */
  void add(const CellBox& other);
};

/** One floor of a site as one map: the layers elevation, ground elevation, variance, state,
 * traversability and sparsity, of which nothing is kept, in the smallest square window that holds
 * all that is known of it. Looks again only at tiles that have changed, so it belongs to one site,
 * of which no tile is erased. */
class FloorMap
{
 public:
  /** Of a floor that is wider than `max_cells` the window has that number along each side, and
   * (x_m, y_m) within a sixteenth of a side of its middle. A window of 0 cells where nothing is
   * known. Valid until the next call. */
  const MapSnapshot& update(
      Site& site, int floor, const Parameters& parameters, int max_cells, double x_m, double y_m);

 private:
  void look_at_changed(Site& site, std::vector<TileKey>& changed);
  void begin(const Window& window);
  void put(Site& site, const TileKey& key);

  MapSnapshot map_;
  int floor_ = -1;  //!< none yet
  std::uint64_t changes_ = 0;  //!< that it has looked at
  std::map<TileKey, CellBox> known_;  //!< of all floors
};

}  // namespace talus::site
