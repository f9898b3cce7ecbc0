#include <talus/site/islands.h>

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "known_cells.h"

namespace talus::site
{
namespace
{
/** Tiles that lie far from all others get a file of their own where the rectangle around all has
 * many blocks of 256 x 256 cells, each of which takes about a millisecond to write. */
struct Rule
{
  double far_m;
  std::int64_t max_blocks;
};
constexpr Rule kRules[] = {{2000, 2000}, {500, 8000}};
constexpr double kNear_m = 250;  // of a way to the tiles that were seen from it

using Tiles = std::vector<TileKey>;
/** A square of tiles; those of squares that touch are not far from each other. */
using Square = std::pair<std::int32_t, std::int32_t>;
using Squares = std::map<Square, Tiles>;

std::int32_t floor_div(std::int32_t a, std::int32_t b)
{
  return a >= 0 ? a / b : -((b - 1 - a) / b);
}

/** Tiles along the side of squares that are so wide, or a little more. */
std::int32_t side_of_square(double wide_m, double tile_m)
{
  return static_cast<std::int32_t>(std::ceil(wide_m / tile_m));
}

Square square_of(const TileKey& key, std::int32_t side)
{
  return {floor_div(key.x, side), floor_div(key.y, side)};
}

bool has_more_blocks(const Tiles& tiles, std::int64_t max)
{
  const auto [west, east] = std::minmax_element(
      tiles.begin(), tiles.end(), [](const TileKey& a, const TileKey& b) { return a.x < b.x; });
  const auto [south, north] = std::minmax_element(
      tiles.begin(), tiles.end(), [](const TileKey& a, const TileKey& b) { return a.y < b.y; });
  const auto blocks = [](std::int64_t first, std::int64_t last) { return (last - first) / 2 + 1; };
  return blocks(west->x, east->x) > max / blocks(south->y, north->y);
}

/** Takes the squares that hang together with the first one out. */
Tiles take_island(Squares& squares)
{
  Tiles tiles;
  std::vector<Square> next{squares.begin()->first};
  while (!next.empty())
  {
    const Square at = next.back();
    next.pop_back();
    const auto found = squares.find(at);
    if (found == squares.end()) continue;
    tiles.insert(tiles.end(), found->second.begin(), found->second.end());
    squares.erase(found);
    for (const int dy : {-1, 0, 1})
      for (const int dx : {-1, 0, 1}) next.emplace_back(at.first + dx, at.second + dy);
  }
  std::sort(tiles.begin(), tiles.end());
  return tiles;
}

std::vector<Tiles> divided(const Tiles& tiles, const Rule& rule, double tile_m)
{
  if (!has_more_blocks(tiles, rule.max_blocks)) return {tiles};
  Squares squares;
  const std::int32_t side = side_of_square(rule.far_m, tile_m);
  for (const TileKey& key : tiles) squares[square_of(key, side)].push_back(key);
  std::vector<Tiles> parts;
  while (!squares.empty()) parts.push_back(take_island(squares));
  return parts;
}

std::vector<Tiles> parts_of(const Tiles& tiles, double tile_m)
{
  if (tiles.empty()) return {};
  std::vector<Tiles> parts{tiles};
  for (const Rule& rule : kRules)
  {
    std::vector<Tiles> next;
    for (const Tiles& part : parts)
      for (Tiles& p : divided(part, rule, tile_m)) next.push_back(std::move(p));
    parts = std::move(next);
  }
  return parts;
}

/** Without tiles in which nothing is known. */
Island island_of(const Tiles& tiles, Site& site)
{
  Island island;
  const auto is_known = [&](const TileKey& key)
  {
    bool known = false;
    for_each_known_of_tile(
        site, key, [&](std::int64_t, std::int64_t, const SiteCell&) { known = true; });
    return known;
  };
  std::copy_if(tiles.begin(), tiles.end(), std::back_inserter(island.tiles), is_known);
  const double tile_m = kTileCells * site.resolution_m;
  island.x_m = (tiles.front().x + 0.5) * tile_m;
  island.y_m = (tiles.front().y + 0.5) * tile_m;
  return island;
}
}  // namespace

std::vector<Island> islands_of(Site& site, int floor)
{
  Tiles tiles;
  for (const TileKey& key : site.tiles.keys())
    if (key.floor == floor) tiles.push_back(key);
  const auto parts = parts_of(tiles, kTileCells * site.resolution_m);
  if (parts.size() < 2) return {};
  std::vector<Island> islands;
  for (const Tiles& part : parts)
    if (Island island = island_of(part, site); !island.tiles.empty())
      islands.push_back(std::move(island));
  std::sort(
      islands.begin(), islands.end(),
      [](const Island& a, const Island& b)
      {
        return a.tiles.size() != b.tiles.size() ? a.tiles.size() > b.tiles.size()
                                                : a.tiles.front() < b.tiles.front();
      });
  return islands;
}

std::vector<std::vector<WayPoint>> ways_on(const Island& island, const Site& site)
{
  const double tile_m = kTileCells * site.resolution_m;
  const std::int32_t side = side_of_square(kNear_m, tile_m);
  std::set<Square> near;
  for (const TileKey& key : island.tiles)
    for (const int dy : {-1, 0, 1})
      for (const int dx : {-1, 0, 1})
      {
        const Square at = square_of(key, side);
        near.emplace(at.first + dx, at.second + dy);
      }
  const auto is_on = [&](const WayPoint& p)
  {
    const auto tile = [&](float m) { return static_cast<std::int32_t>(std::floor(m / tile_m)); };
    return p.floor == island.tiles.front().floor &&
           near.count(square_of({p.floor, tile(p.x_m), tile(p.y_m)}, side)) > 0;
  };
  std::vector<std::vector<WayPoint>> runs;
  for (const auto& way : site.ways)
  {
    bool goes_on = false;
    for (const WayPoint& p : way)
    {
      const bool on = is_on(p);
      if (on && !goes_on) runs.emplace_back();
      if (on) runs.back().push_back(p);
      goes_on = on;
    }
  }
  return runs;
}

std::string text_of_island(const Island& island, const std::string& file)
{
  const std::size_t count = island.tiles.size();
  return "the site map goes on far away: " + file + " has " + std::to_string(count) +
         (count == 1 ? " tile" : " tiles") + " near (" + fixed_text(island.x_m, 0) + ", " +
         fixed_text(island.y_m, 0) +
         ") m. Did a pose jump? --keep-far writes one file, which takes long";
}

}  // namespace talus::site
