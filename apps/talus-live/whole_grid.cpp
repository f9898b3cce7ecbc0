#include "whole_grid.h"

#include <talus/formats/write.h>
#include <talus/io/layer_stack.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "cell_bands.h"

namespace talus::app
{
using site::kTileCells;

namespace
{
/** How far a cell has to do with others. */
std::int64_t margin_cells(double close_islands_m, double resolution_m)
{
  return 1 + static_cast<std::int64_t>(std::ceil(close_islands_m / resolution_m));
}
/** A square of cells, row by row, from (x, y) on; what is unknown in it changes nothing. */
void put(
    std::int64_t x, std::int64_t y, int side, const std::int8_t* from, const WholeGrid::Area& area,
    live::Grid& grid)
{
  const auto first_x = std::max(x, area.min_x), end_x = std::min(x + side, area.end_x);
  for (auto iy = std::max(y, area.min_y); iy < std::min(y + side, area.end_y); ++iy)
    for (auto ix = first_x; ix < end_x; ++ix)
      if (const auto cell = from[(iy - y) * side + (ix - x)]; cell >= 0)
        grid.cells[static_cast<std::size_t>((iy - area.min_y) * grid.cells_x + (ix - area.min_x))] =
            cell;
}

template <class Tiles>
live::Grid cells_of(const Tiles& tiles, const WholeGrid::Area& area, double resolution_m)
{
  live::Grid grid;
  grid.cells_x = static_cast<int>(area.end_x - area.min_x);
  grid.cells_y = static_cast<int>(area.end_y - area.min_y);
  grid.resolution_m = resolution_m;
  grid.min_x_m = static_cast<double>(area.min_x) * resolution_m;
  grid.min_y_m = static_cast<double>(area.min_y) * resolution_m;
  grid.cells.assign(static_cast<std::size_t>(grid.cells_x) * grid.cells_y, -1);
  for (const auto& [key, cells] : tiles)
    put(site::cell_of_tile(key.x, 0), site::cell_of_tile(key.y, 0), kTileCells, cells.data(), area,
        grid);
  return grid;
}
}  // namespace

void WholeGrid::Area::add(std::int64_t x, std::int64_t y, std::int64_t cells)
{
  min_x = std::min(min_x, x);
  min_y = std::min(min_y, y);
  end_x = std::max(end_x, x + cells);
  end_y = std::max(end_y, y + cells);
}

void WholeGrid::read(site::TileStore& tiles, const site::TileKey& key)
{
  const site::Tile* tile = tiles.find(key);
  if (!tile) return;
  Cells& cells = tiles_[key];
  for (std::size_t i = 0; i < cells.size(); ++i)
  {
    const float score = site::kept_values(tile->cells[i].cell)[0];
    cells[i] = std::isnan(score) ? std::int8_t{-1} : std::int8_t(score <= 0 ? 100 : 0);
  }
  const auto x = site::cell_of_tile(key.x, 0), y = site::cell_of_tile(key.y, 0);
  area_.add(x, y, kTileCells);
  changed_.add(x, y, kTileCells);
}

void WholeGrid::update(
    site::TileStore& tiles, int floor, const Window& window, const std::vector<std::int8_t>& cells)
{
  if (floor_ != floor)
  {
    *this = WholeGrid(close_islands_m_);
    floor_ = floor;
  }
  for (const auto& key : tiles.take_changed(changes_))
    if (key.floor == floor) read(tiles, key);
  for (const Window& w : {window_, window})
    if (w.cells > 0) changed_.add(w.min_cell_x, w.min_cell_y, w.cells);
  const auto down = [](std::int64_t cell) { return site::cell_of_tile(site::tile_of(cell), 0); };
  for (const std::int64_t far : {0, window.cells - 1})  // its tiles
    area_.add(down(window.min_cell_x + far), down(window.min_cell_y + far), kTileCells);
  window_ = window;
  window_cells_ = cells;
}

WholeGrid::Area WholeGrid::take_changed()
{
  Area changed = std::exchange(changed_, {});
  if (changed.empty() || window_.cells == 0) return changed;
  changed = changed.grown(margin_cells(close_islands_m_, window_.resolution_m));
  changed = {
      std::max(changed.min_x, area_.min_x), std::max(changed.min_y, area_.min_y),
      std::min(changed.end_x, area_.end_x), std::min(changed.end_y, area_.end_y)};
  close(changed);
  return changed;
}

/** As islands are small, what is around an area tells all of them in it. */
void WholeGrid::close(const Area& area)
{
  const auto margin = margin_cells(close_islands_m_, window_.resolution_m);
  const live::Grid around = open_cells(area.grown(margin), window_.resolution_m);
  io::LayerStack map;
  map.cells_x = around.cells_x;
  map.cells_y = around.cells_y;
  map.resolution_m = window_.resolution_m;
  map.names = {layer_name(Layer::Traversability)};
  auto& scores = map.layers.emplace_back();
  scores.reserve(around.cells.size());
  for (const auto cell : around.cells) scores.push_back(cell < 0 ? NAN : cell == 0 ? 1.0F : 0.0F);
  const auto closed = formats::ros_cells(map, {0.0, close_islands_m_});
  for (auto y = area.min_y; y < area.end_y; ++y)
    for (auto x = area.min_x; x < area.end_x;)
    {
      const site::TileKey key{0, site::tile_of(x), site::tile_of(y)};
      const auto [tile, is_new] = closed_.try_emplace(key);
      if (is_new) tile->second.fill(-1);
      const auto end = std::min(area.end_x, site::cell_of_tile(key.x + 1, 0));
      std::copy_n(
          closed.begin() + (y - area.min_y + margin) * around.cells_x + (x - area.min_x + margin),
          end - x,
          tile->second.begin() + site::index_in_tile(y) * kTileCells + site::index_in_tile(x));
      x = end;
    }
}

live::Grid WholeGrid::cells(const Area& area, double resolution_m) const
{
  return cells_of(closed_, area, resolution_m);
}

live::Grid WholeGrid::open_cells(const Area& area, double resolution_m) const
{
  live::Grid grid = cells_of(tiles_, area, resolution_m);
  put(window_.min_cell_x, window_.min_cell_y, window_.cells, window_cells_.data(), area, grid);
  return grid;
}

}  // namespace talus::app
