#pragma once
#include <talus/site/tile_store.h>
#include <talus/cell_record.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>

// Rectangles of the global grid of cells: what enters and leaves a window, and which tiles it is
// in.
namespace talus::site
{
inline CellRect rect_of(const Window& w) { return {w.min_cell_x, w.min_cell_y, w.cells, w.cells}; }
inline bool is_same_window(const Window& a, const Window& b)
{
  return a.min_cell_x == b.min_cell_x && a.min_cell_y == b.min_cell_y;
}
inline bool overlap(const Window& a, const Window& b)
{
  return std::abs(a.min_cell_x - b.min_cell_x) < a.cells &&
         std::abs(a.min_cell_y - b.min_cell_y) < a.cells;
}

/** Cells of one window that are not in another, at one side of it: of two windows that overlap. */
struct Strip
{
  CellRect cells;
  CellRect beside;  //!< the column or row of both windows next to it
  bool is_upright;

  static Strip beside_x(const Window& of, const Window& but)
  {
    const std::int64_t moved = of.min_cell_x - but.min_cell_x;
    const int width = static_cast<int>(std::abs(moved));
    const std::int64_t min_x = moved > 0 ? of.min_cell_x + of.cells - width : of.min_cell_x;
    return {
        {min_x, of.min_cell_y, width, of.cells},
        {moved > 0 ? min_x - 1 : min_x + width, of.min_cell_y, width > 0 ? 1 : 0, of.cells},
        true};
  }
  /** Without what is beside_x(). */
  static Strip beside_y(const Window& of, const Window& but)
  {
    const std::int64_t moved = of.min_cell_y - but.min_cell_y;
    const int height = static_cast<int>(std::abs(moved));
    const std::int64_t min_y = moved > 0 ? of.min_cell_y + of.cells - height : of.min_cell_y;
    const std::int64_t min_x = std::max(of.min_cell_x, but.min_cell_x);
    const int width = of.cells - static_cast<int>(std::abs(of.min_cell_x - but.min_cell_x));
    return {
        {min_x, min_y, width, height},
        {min_x, moved > 0 ? min_y - 1 : min_y + height, width, height > 0 ? 1 : 0},
        false};
  }
};

/** What is kept of a window when it moves: the cells at its edge, some of which leave, and as many
 * next to them as leave, which come to the edge. */
struct Leaving
{
  CellRect coming, edge;

  Leaving(const Strip& strip, const Window& window, int edge_cells)
      : coming(strip.cells), edge(strip.cells)
  {
    const bool upright = strip.is_upright;
    const int leave = upright ? coming.width_cells : coming.height_cells;
    const int width = leave > 0 ? std::min(edge_cells, window.cells - leave) : 0;
    (upright ? edge.width_cells : edge.height_cells) = width;
    const auto first = [upright](CellRect& r) -> std::int64_t&
    { return upright ? r.min_cell_x : r.min_cell_y; };
    CellRect beside = strip.beside;
    if (first(beside) < first(edge))
    {
      first(edge) += leave - width;
      first(coming) -= width;
    }
    else
      first(coming) += width;
  }
};

/** Whether a cell of the window is fewer than `fewer_than` cells from its edge. */
inline bool is_at_edge(const Window& w, std::int64_t cell_x, std::int64_t cell_y, int fewer_than)
{
  const std::int64_t x = cell_x - w.min_cell_x, y = cell_y - w.min_cell_y;
  return std::min({x, y, w.cells - 1 - x, w.cells - 1 - y}) < fewer_than;
}

/** The part of a rectangle in one tile; x and y count from the rectangle. */
struct TilePart
{
  TileKey key;
  int x, y, width, height;
};

/** Calls f(part) for each tile that a rectangle reaches into. */
template <class F>
void for_each_tile(const CellRect& r, int floor, const F& f)
{
  const auto length = [](std::int64_t first, int size, int from)
  { return std::min(size - from, kTileCells - index_in_tile(first + from)); };
  for (int y = 0, height = 0; y < r.height_cells; y += height)
  {
    height = length(r.min_cell_y, r.height_cells, y);
    for (int x = 0, width = 0; x < r.width_cells; x += width)
    {
      width = length(r.min_cell_x, r.width_cells, x);
      const TileKey key{floor, tile_of(r.min_cell_x + x), tile_of(r.min_cell_y + y)};
      f(TilePart{key, x, y, width, height});
    }
  }
}

/** Calls f(index in the rectangle, index in the tile) for the cells of a part. */
template <class F>
void for_each_cell(const CellRect& r, const TilePart& part, const F& f)
{
  const int tile_x = index_in_tile(r.min_cell_x + part.x);
  const int tile_y = index_in_tile(r.min_cell_y + part.y);
  for (int row = 0; row < part.height; ++row)
  {
    const auto from = static_cast<std::size_t>((part.y + row) * r.width_cells + part.x);
    const auto to = static_cast<std::size_t>((tile_y + row) * kTileCells + tile_x);
    for (std::size_t i = 0; i < static_cast<std::size_t>(part.width); ++i) f(from + i, to + i);
  }
}

/** Calls f(index in the rectangle, CellRecord) for the cells of a rectangle in those tiles of a
 * floor that there are. */
template <class F>
void for_each_kept_cell(TileStore& tiles, const CellRect& r, int floor, const F& f)
{
  const auto look_up = [&](const TilePart& part)
  {
    const Tile* tile = tiles.find(part.key);
    if (!tile) return;
    for_each_cell(r, part, [&](std::size_t i, std::size_t at) { f(i, tile->cells[at].cell); });
  };
  for_each_tile(r, floor, look_up);
}

}  // namespace talus::site
