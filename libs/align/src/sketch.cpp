#include "sketch.h"

#include <known_cells.h>

#include <cmath>
#include <limits>
#include <memory>

namespace talus::align
{
namespace
{
constexpr float kStands_m = 0.15f;  //!< above its own ground: lower things hide in its noise
}

Sketch::Sketch(const Grid& grid)
    : grid_(grid),
      ground_m_(grid.height, grid.width, std::numeric_limits<float>::quiet_NaN()),
      count_(grid.height, grid.width, 0.0F),
      stands_(grid.height, grid.width, uchar{0})
{
}

void Sketch::add(
    std::int64_t cell_x, std::int64_t cell_y, double resolution_m, const site::SiteCell& s)
{
  const cv::Point2d p = grid_.at(
      (static_cast<double>(cell_x) + 0.5) * resolution_m,
      (static_cast<double>(cell_y) + 0.5) * resolution_m);
  const int column = static_cast<int>(std::lround(p.x)), row = static_cast<int>(std::lround(p.y));
  if (column < 0 || row < 0 || column >= grid_.width || row >= grid_.height) return;
  if (s.cell.elevation_m - s.cell.ground_m > kStands_m) stands_(row, column) = 1;
  if (!site::is_measured(s)) return;
  float& ground_m = ground_m_(row, column);
  float& count = count_(row, column);
  ground_m = count > 0 ? ground_m + (s.cell.ground_m - ground_m) / (count + 1) : s.cell.ground_m;
  count += 1;
}

void Sketch::add(site::MovedReader& map)
{
  const auto tile = std::make_unique<site::Tile>();
  for (const auto& place : map.tiles())
  {
    if (!map.read(place, *tile)) continue;
    for (int i = 0; i < site::kTileCells * site::kTileCells; ++i)
      if (const auto& s = tile->cells[static_cast<std::size_t>(i)]; s.known())
        add(site::cell_of_tile(place.x, i % site::kTileCells),
            site::cell_of_tile(place.y, i / site::kTileCells), map.file().info().resolution_m, s);
  }
}

}  // namespace talus::align
