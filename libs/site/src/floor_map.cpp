#include <talus/site/floor_map.h>

#include "strips.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::site
{
namespace
{
/** Bounds of cells along one axis. */
struct Span
{
  std::int64_t min = std::numeric_limits<std::int64_t>::max();
  std::int64_t max = std::numeric_limits<std::int64_t>::min();

  void add(std::int64_t cell)
  {
    min = std::min(min, cell);
    max = std::max(max, cell);
  }
  bool empty() const { return min > max; }
  std::int64_t size() const { return max - min + 1; }
};

struct Bounds
{
  Span x, y;
};

Bounds bounds_of(Site& site, int floor)
{
  Bounds b;
  for (const TileKey& key : site.tiles.keys())
  {
    if (key.floor != floor) continue;
    const Tile& tile = *site.tiles.find(key);
    for (std::size_t i = 0; i < tile.cells.size(); ++i)
    {
      if (!tile.cells[i].known()) continue;
      const auto at = static_cast<int>(i);
      b.x.add(static_cast<std::int64_t>(key.x) * kTileCells + at % kTileCells);
      b.y.add(static_cast<std::int64_t>(key.y) * kTileCells + at / kTileCells);
    }
  }
  return b;
}

constexpr Layer kLayers[] = {
    Layer::Elevation, Layer::GroundElevation, Layer::Variance, Layer::State, Layer::Traversability};

void put(MapSnapshot& map, std::size_t at, const CellRecord& c)
{
  const float values[] = {
      c.elevation_m, c.ground_m, c.ground_variance_m2, static_cast<float>(c.state),
      c.traversability};
  for (std::size_t i = 0; i < std::size(kLayers); ++i)
    map.layers[static_cast<std::size_t>(kLayers[i])][at] = values[i];
}
}  // namespace

MapSnapshot floor_map(
    Site& site, int floor, const Parameters& parameters, int most_cells, double x_m, double y_m)
{
  MapSnapshot map;
  map.parameters = parameters;
  const Bounds known = bounds_of(site, floor);
  if (known.x.empty()) return map;
  const std::int64_t wanted = std::max(known.x.size(), known.y.size());
  const int side = static_cast<int>(std::min<std::int64_t>(wanted, most_cells));
  const auto first = [&](const Span& span, double middle_m)
  {
    if (span.size() <= side) return span.min;
    const auto middle = static_cast<std::int64_t>(std::floor(middle_m / site.resolution_m));
    return std::clamp(middle - side / 2, span.min, span.max - side + 1);
  };
  map.window = {side, site.resolution_m, first(known.x, x_m), first(known.y, y_m)};
  const CellRect all = rect_of(map.window);
  map.layers[static_cast<std::size_t>(Layer::Sparsity)].assign(all.size(), NAN);
  for (const Layer l : kLayers)
    map.layers[static_cast<std::size_t>(l)].assign(all.size(), l == Layer::State ? 0.0f : NAN);
  for_each_tile(
      all, floor,
      [&](const TilePart& part)
      {
        const Tile* tile = site.tiles.find(part.key);
        if (!tile) return;
        for_each_cell(
            all, part, [&](std::size_t i, std::size_t at) { put(map, i, tile->cells[at].cell); });
      });
  return map;
}

}  // namespace talus::site
