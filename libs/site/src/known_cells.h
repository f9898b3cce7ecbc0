#pragma once
#include <talus/layers.h>
#include <talus/site/floor_map.h>
#include <talus/site/site.h>
#include <talus/site/tile_store.h>

#include <cmath>
#include <cstdint>

namespace talus::site
{
/** Calls f(cell x, cell y, SiteCell) for the known cells of a tile. */
template <class F>
void for_each_known_of_tile(Site& site, const TileKey& key, const F& f)
{
  const Tile* tile = site.tiles.find(key);
  const std::int64_t x0 = std::int64_t{key.x} * kTileCells, y0 = std::int64_t{key.y} * kTileCells;
  for (int i = 0; tile && i < kTileCells * kTileCells; ++i)
  {
    const SiteCell& c = tile->cells[static_cast<std::size_t>(i)];
    if (c.known()) f(x0 + i % kTileCells, y0 + i / kTileCells, c);
  }
}

/** The same for the known cells of a floor, tile by tile. */
template <class F>
void for_each_known(Site& site, int floor, const F& f)
{
  for (const TileKey& key : site.tiles.keys())
    if (key.floor == floor) for_each_known_of_tile(site, key, f);
}

CellBox known_box(Site& site, int floor);

inline bool is_measured(const SiteCell& s)
{
  return s.cell.state == static_cast<std::uint8_t>(CellState::Measured);
}
inline bool has_elevation(const SiteCell& s) { return !std::isnan(s.cell.elevation_m); }
/** Whether it was seen if something stands there. */
inline bool has_seen(const SiteCell& s) { return is_measured(s) || has_elevation(s); }

}  // namespace talus::site
