#include <talus/site/floor_map.h>

#include "cell_bands.h"
#include "kept_cell.h"
#include "known_cells.h"
#include "strips.h"

#include <algorithm>
#include <cmath>

namespace talus::site
{
namespace
{
void put_cell(MapSnapshot& map, std::size_t at, const CellRecord& c)
{
  const auto values = kept_values(c);
  for (std::size_t i = 0; i < values.size(); ++i)
    map.layers[static_cast<std::size_t>(kKeptLayers[i])][at] = values[i];
}

Window window_around(
    const CellBox& known, double resolution_m, int max_cells, double x_m, double y_m)
{
  const std::int64_t wanted = std::max(known.max_x - known.min_x, known.max_y - known.min_y) + 1;
  const int side = static_cast<int>(std::min<std::int64_t>(wanted, max_cells));
  const auto first = [&](std::int64_t min, std::int64_t max, double middle_m)
  {
    if (max - min < side) return min;
    const int step = std::max(side / 8, 1);  // all is put anew where it moves
    const auto middle =
        static_cast<std::int64_t>(std::floor(middle_m / (resolution_m * step))) * step + step / 2;
    return std::clamp(middle - side / 2, min, max - side + 1);
  };
  return {
      side, resolution_m, first(known.min_x, known.max_x, x_m),
      first(known.min_y, known.max_y, y_m)};
}
}  // namespace

const MapSnapshot& FloorMap::update(
    Site& site, int floor, const Parameters& parameters, int max_cells, double x_m, double y_m)
{
  std::vector<TileKey> changed = site.tiles.take_changed(changes_);
  look_at_changed(site, changed);
  CellBox known;
  for (const auto& [key, box] : known_)
    if (key.floor == floor) known.add(box);
  map_.parameters = parameters;
  const Window window =
      known.empty() ? Window{} : window_around(known, site.resolution_m, max_cells, x_m, y_m);
  if (floor != floor_ || window.cells != map_.window.cells || !is_same_window(window, map_.window))
  {
    begin(window);
    changed.clear();
    for (const auto& entry : known_) changed.push_back(entry.first);
  }
  floor_ = floor;
  for (const TileKey& key : changed)
    if (key.floor == floor) put(site, key);
  return map_;
}

void FloorMap::look_at_changed(Site& site, std::vector<TileKey>& changed)
{
  for (const TileKey& key : changed)
  {
    CellBox box;
    for_each_known_of_tile(
        site, key, [&](std::int64_t x, std::int64_t y, const SiteCell&) { box.add(x, y); });
    known_[key] = box;
  }
}

void FloorMap::begin(const Window& window)
{
  const CellRect all = rect_of(window);
  map_.window = window;
  map_.layers[static_cast<std::size_t>(Layer::Sparsity)].assign(all.size(), NAN);
  for (const Layer l : kKeptLayers)
    map_.layers[static_cast<std::size_t>(l)].assign(all.size(), l == Layer::State ? 0.0F : NAN);
}

/** The cells of a tile that are in the window. */
void FloorMap::put(Site& site, const TileKey& key)
{
  const Tile* tile = site.tiles.find(key);
  const Window& w = map_.window;
  const std::int64_t left = std::int64_t{key.x} * kTileCells - w.min_cell_x;
  const std::int64_t low = std::int64_t{key.y} * kTileCells - w.min_cell_y;
  const auto inside = [](std::int64_t at, std::int64_t from)
  { return std::clamp<std::int64_t>(at, from, from + kTileCells); };
  const std::int64_t end_x = inside(w.cells, left), end_y = inside(w.cells, low);
  for (std::int64_t y = inside(0, low); tile && y < end_y; ++y)
    for (std::int64_t x = inside(0, left); x < end_x; ++x)
      put_cell(
          map_, static_cast<std::size_t>(y * w.cells + x),
          tile->cells[static_cast<std::size_t>((y - low) * kTileCells + (x - left))].cell);
}

void CellBox::add(std::int64_t x, std::int64_t y)
{
  min_x = std::min(min_x, x);
  max_x = std::max(max_x, x);
  min_y = std::min(min_y, y);
  max_y = std::max(max_y, y);
}

void CellBox::add(const CellBox& other)
{
  min_x = std::min(min_x, other.min_x);
  max_x = std::max(max_x, other.max_x);
  min_y = std::min(min_y, other.min_y);
  max_y = std::max(max_y, other.max_y);
}

CellBox known_box(Site& site, int floor)
{
  CellBox box;
  for_each_known(
      site, floor, [&](std::int64_t x, std::int64_t y, const SiteCell&) { box.add(x, y); });
  return box;
}

}  // namespace talus::site
