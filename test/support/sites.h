#pragma once
// Sites made on the spot, and what is compared of their cells.
#include <talus/site/site.h>

#include <cmath>
#include <cstdint>
#include <string>

namespace talus::test
{
inline site::SiteCell measured(float ground_m, std::uint32_t seen_s = 0, float variance_m2 = 1e-4F)
{
  site::SiteCell c;
  c.cell.ground_m = ground_m;
  c.cell.ground_variance_m2 = variance_m2;
  c.cell.traversability = 1;
  c.cell.state = 1;
  c.seen_s = seen_s;
  return c;
}

inline site::SiteCell with_obstacle(site::SiteCell c, float height_m)
{
  c.cell.elevation_m = c.cell.ground_m + height_m;
  c.cell.elevation_variance_m2 = 2e-4F;
  c.cell.traversability = 0;
  c.cell.evidence[1] = 5;
  return c;
}

inline site::SiteCell& cell_at(site::Site& s, std::int64_t x, std::int64_t y, int floor = 0)
{
  return s.tiles.at({floor, site::tile_of(x), site::tile_of(y)})
      .cells
          [static_cast<std::size_t>(site::index_in_tile(y)) * site::kTileCells +
           static_cast<std::size_t>(site::index_in_tile(x))];
}

/** The same, unknown where there is no tile. */
inline site::SiteCell known_at(site::Site& s, std::int64_t x, std::int64_t y, int floor = 0)
{
  const bool has_tile = s.tiles.has({floor, site::tile_of(x), site::tile_of(y)});
  return has_tile ? cell_at(s, x, y, floor) : site::SiteCell{};
}

/** A value of the channels of a cell, by layer. */
inline float& value_at(
    site::Site& s, std::int64_t x, std::int64_t y, std::size_t layer, int floor = 0)
{
  return s.channel_tiles.at({floor, site::tile_of(x), site::tile_of(y)})
      .cells
          [static_cast<std::size_t>(site::index_in_tile(y)) * site::kTileCells +
           static_cast<std::size_t>(site::index_in_tile(x))]
      .values[layer];
}

/** All that a cell holds, without the bytes between its members. */
inline std::string bytes_of(const site::SiteCell& s)
{
  const CellRecord& c = s.cell;
  std::string bytes;
  const auto add = [&](const auto& v)
  { bytes.append(reinterpret_cast<const char*>(&v), sizeof v); };
  add(c.ground_m), add(c.ground_variance_m2), add(c.elevation_m), add(c.elevation_variance_m2);
  add(c.traversability), add(c.state), add(c.evidence), add(s.seen_s);
  return bytes;
}

/** How many known cells of `a` have other bytes in `b`, both ways. */
inline int different_cells(site::Site& a, site::Site& b)
{
  int different = 0;
  for (site::Site* one : {&a, &b})
  {
    site::Site& other = one == &a ? b : a;
    for (const auto& key : one->tiles.keys())
    {
      const auto tile = *one->tiles.find(key);
      const site::Tile* same = other.tiles.find(key);
      for (std::size_t i = 0; i < tile.cells.size(); ++i)
        if (tile.cells[i].known() && (!same || bytes_of(tile.cells[i]) != bytes_of(same->cells[i])))
          ++different;
    }
  }
  return different;
}

}  // namespace talus::test
