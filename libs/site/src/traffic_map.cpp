#include <talus/site/traffic_map.h>

#include "traffic.h"

#include <talus/io/geotiff.h>
#include <talus/site/islands.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace talus::site
{
namespace
{
/** Empty where nothing moved in these tiles. */
io::LayerStack layers_of(const Traffic& traffic, const std::vector<TileKey>& keys, double cell_m)
{
  std::vector<TileKey> moved;
  for (const TileKey& key : keys)
    if (const auto tile = traffic.find(key); tile != traffic.end() && !tile->second.cells.empty())
      moved.push_back(key);
  if (moved.empty()) return {};
  const auto [west, east] = std::minmax_element(
      moved.begin(), moved.end(), [](const TileKey& a, const TileKey& b) { return a.x < b.x; });
  const int min_x = west->x, min_y = moved.front().y;  // they ascend
  const int tiles_x = east->x - min_x + 1, tiles_y = moved.back().y - min_y + 1;
  io::LayerStack stack{
      tiles_x * kTileCells,
      tiles_y * kTileCells,
      cell_m,
      min_x * kTileCells * cell_m,
      min_y * kTileCells * cell_m,
      {"times", "scans"},
      {}};
  const auto width = static_cast<std::size_t>(stack.cells_x);
  stack.layers.assign(2, std::vector<float>(width * static_cast<std::size_t>(stack.cells_y), NAN));
  const auto put = [&](std::size_t layer, const TileKey& key, int place, float value)
  {
    const int x = (key.x - min_x) * kTileCells + place % kTileCells;
    const int y = (key.y - min_y) * kTileCells + place / kTileCells;
    stack.layers[layer][static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] = value;
  };
  for (const TileKey& key : moved)
    for (const auto& [place, cell] : traffic.at(key).cells)
    {
      put(0, key, place, static_cast<float>(cell.times));
      put(1, key, place, static_cast<float>(cell.scans));
    }
  return stack;
}

std::vector<TileKey> tiles_of(const Site& site, int floor)
{
  std::vector<TileKey> tiles;
  for (const TileKey& key : site.tiles.keys())
    if (key.floor == floor) tiles.push_back(key);
  return tiles;
}
}  // namespace

void write_traffic_files(const std::string& path, const Traffic& traffic, Site& site, Far far)
{
  for (const int floor : floors_of(site))
  {
    auto islands = far == Far::Apart ? islands_of(site, floor) : std::vector<Island>();
    if (islands.empty()) islands.push_back({tiles_of(site, floor)});
    for (std::size_t i = 0; i < islands.size(); ++i)
    {
      const io::LayerStack stack = layers_of(traffic, islands[i].tiles, site.resolution_m);
      if (stack.layers.empty()) continue;
      io::write_geotiff(with_island(with_floor(path, floor), i), stack, {}, site.origin);
    }
  }
}

}  // namespace talus::site
