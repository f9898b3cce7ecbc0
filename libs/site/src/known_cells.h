#pragma once
#include <talus/site/site.h>

#include <cstdint>

namespace talus::site
{
/** From the first to the last known cell. */
struct CellBox
{
  std::int64_t min_x = INT64_MAX, min_y = INT64_MAX, max_x = INT64_MIN, max_y = INT64_MIN;

  bool empty() const { return min_x > max_x; }
  void add(std::int64_t x, std::int64_t y);
};

/** Calls f(cell x, cell y, SiteCell) for the known cells of a floor, tile by tile. */
template <class F>
void for_each_known(Site& site, int floor, const F& f)
{
  for (const TileKey& key : site.tiles.keys())
  {
    if (key.floor != floor) continue;
    const Tile* tile = site.tiles.find(key);
    const std::int64_t x0 = std::int64_t{key.x} * kTileCells, y0 = std::int64_t{key.y} * kTileCells;
    for (int i = 0; tile && i < kTileCells * kTileCells; ++i)
    {
      const SiteCell& c = tile->cells[static_cast<std::size_t>(i)];
      if (c.known()) f(x0 + i % kTileCells, y0 + i / kTileCells, c);
    }
  }
}

CellBox known_box(Site& site, int floor);

}  // namespace talus::site
