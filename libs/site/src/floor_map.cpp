#include <talus/site/floor_map.h>

#include "known_cells.h"
#include "strips.h"

#include <algorithm>
#include <cmath>

namespace talus::site
{
namespace
{
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
  const CellBox known = known_box(site, floor);
  if (known.empty()) return map;
  const std::int64_t wanted = std::max(known.max_x - known.min_x, known.max_y - known.min_y) + 1;
  const int side = static_cast<int>(std::min<std::int64_t>(wanted, most_cells));
  const auto first = [&](std::int64_t min, std::int64_t max, double middle_m)
  {
    if (max - min < side) return min;
    const auto middle = static_cast<std::int64_t>(std::floor(middle_m / site.resolution_m));
    return std::clamp(middle - side / 2, min, max - side + 1);
  };
  map.window = {
      side, site.resolution_m, first(known.min_x, known.max_x, x_m),
      first(known.min_y, known.max_y, y_m)};
  const CellRect all = rect_of(map.window);
  map.layers[static_cast<std::size_t>(Layer::Sparsity)].assign(all.size(), NAN);
  for (const Layer l : kLayers)
    map.layers[static_cast<std::size_t>(l)].assign(all.size(), l == Layer::State ? 0.0f : NAN);
  for_each_kept_cell(
      site.tiles, all, floor, [&](std::size_t i, const CellRecord& kept) { put(map, i, kept); });
  return map;
}

}  // namespace talus::site
