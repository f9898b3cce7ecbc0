#include <talus/site/islands.h>

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

namespace talus::site
{
namespace
{
constexpr std::int64_t kManyBlocks = 500'000;
constexpr std::size_t kFewer = 10;

/** A square of kFar_m or a little more: tiles of squares that touch are not far from each other. */
using Square = std::pair<std::int32_t, std::int32_t>;
using Squares = std::map<Square, std::vector<TileKey>>;

std::int32_t floor_div(std::int32_t a, std::int32_t b)
{
  return a >= 0 ? a / b : -((b - 1 - a) / b);
}

bool is_enormous(const std::vector<TileKey>& tiles)
{
  if (tiles.empty()) return false;
  const auto [west, east] = std::minmax_element(
      tiles.begin(), tiles.end(), [](const TileKey& a, const TileKey& b) { return a.x < b.x; });
  const auto [south, north] = std::minmax_element(
      tiles.begin(), tiles.end(), [](const TileKey& a, const TileKey& b) { return a.y < b.y; });
  const auto blocks = [](std::int64_t first, std::int64_t last) { return (last - first) / 2 + 1; };
  return blocks(west->x, east->x) > kManyBlocks / blocks(south->y, north->y);
}

/** Takes the squares that hang together with the first one out. */
std::vector<TileKey> take_island(Squares& squares)
{
  std::vector<TileKey> tiles;
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
  return tiles;
}

Island island_of(std::vector<TileKey> tiles, double tile_m)
{
  Island island;
  island.x_m = (tiles.front().x + 0.5) * tile_m;
  island.y_m = (tiles.front().y + 0.5) * tile_m;
  island.tiles = std::move(tiles);
  return island;
}
}  // namespace

std::vector<Island> far_islands(const Site& site, int floor)
{
  std::vector<TileKey> tiles;
  for (const TileKey& key : site.tiles.keys())
    if (key.floor == floor) tiles.push_back(key);
  if (!is_enormous(tiles)) return {};
  const double tile_m = kTileCells * site.resolution_m;
  const auto side = static_cast<std::int32_t>(std::ceil(kFar_m / tile_m));
  Squares squares;
  for (const TileKey& key : tiles)
    squares[{floor_div(key.x, side), floor_div(key.y, side)}].push_back(key);
  std::vector<std::vector<TileKey>> parts;
  while (!squares.empty()) parts.push_back(take_island(squares));
  std::size_t most = 0;
  for (const auto& part : parts) most = std::max(most, part.size());
  std::vector<Island> islands;
  for (auto& part : parts)
    if (part.size() * kFewer < most) islands.push_back(island_of(std::move(part), tile_m));
  return islands;
}

std::string text_of_left_out(const Island& island)
{
  return "the site map leaves out " + std::to_string(island.tiles.size()) +
         " of its tiles, near (" + fixed_text(island.x_m, 0) + ", " + fixed_text(island.y_m, 0) +
         ") m and more than " + fixed_text(kFar_m / 1000, 0) +
         " km from all others: did a pose jump? --keep-far keeps them, in a file that takes long "
         "to "
         "write";
}

void leave_out(const Island& island, Site& site)
{
  const double tile_m = kTileCells * site.resolution_m;
  const std::set<TileKey> gone(island.tiles.begin(), island.tiles.end());
  const auto is_there = [&](const WayPoint& p)
  {
    return gone.count(
               {p.floor, static_cast<std::int32_t>(std::floor(p.x_m / tile_m)),
                static_cast<std::int32_t>(std::floor(p.y_m / tile_m))}) > 0;
  };
  for (const TileKey& key : island.tiles) site.tiles.erase(key);
  for (auto& way : site.ways)
    way.erase(std::remove_if(way.begin(), way.end(), is_there), way.end());
  const auto is_empty = [](const auto& way) { return way.empty(); };
  site.ways.erase(std::remove_if(site.ways.begin(), site.ways.end(), is_empty), site.ways.end());
}

}  // namespace talus::site
