#pragma once
#include <talus/formats/map_strips.h>
#include <talus/formats/write.h>
#include <talus/io/layer_stack.h>
#include <talus/layers.h>

#include <cmath>
#include <picture_relief.h>
#include <vector>

namespace talus::formats
{
/** A layer of a map; throws std::runtime_error that names it where there is none. */
const std::vector<float>& needed_layer(const io::LayerStack& map, Layer layer);

/** The heights of a map, by cell. */
struct Heights
{
  explicit Heights(const io::LayerStack& map)
      : ground(needed_layer(map, Layer::GroundElevation)), top(needed_layer(map, Layer::Elevation))
  {
  }
  /** Whether something stands on the ground: what is lower is rough ground. */
  bool stands(std::size_t i) const
  {
    return top[i] - ground[i] > static_cast<float>(io::kMinObstacle_m);
  }

  const std::vector<float>& ground;
  const std::vector<float>& top;
};

/** f(index, column, row) of each cell, rows from the south. */
template <class F>
void for_each_cell(const io::LayerStack& map, F f)
{
  std::size_t i = 0;
  for (int iy = 0; iy < map.cells_y; ++iy)
    for (int ix = 0; ix < map.cells_x; ++ix) f(i++, ix, iy);
}

/** The same of a strip, without its margins. */
template <class F>
void for_each_cell(const Strip& strip, F f)
{
  std::size_t i = static_cast<std::size_t>(strip.begin) * strip.map.cells_x;
  for (int iy = strip.begin; iy < strip.end; ++iy)
    for (int ix = 0; ix < strip.map.cells_x; ++ix) f(i++, ix, iy);
}

/** Whether a cell whose traversability is known is occupied. */
inline bool is_blocked(float traversability, double blocked_at)
{
  return traversability <= static_cast<float>(blocked_at);
}

/** Middle of a cell, map frame [m]. */
inline double middle_x_m(const io::LayerStack& map, int ix)
{
  return map.min_x_m + (ix + 0.5) * map.resolution_m;
}
inline double middle_y_m(const io::LayerStack& map, int iy)
{
  return map.min_y_m + (iy + 0.5) * map.resolution_m;
}

/** See MapStrips::joined(). */
io::LayerStack joined_cells(const io::LayerStack& map);

/** A map with its cells joined until fits(map) holds. */
template <class F>
MapStrips joined_until(const F& fits, MapStrips map)
{
  while (!fits(map)) map = map.joined();
  return map;
}

/** "548000 4076000 0" */
std::string text_of(const FileOrigin& origin);

/** Whether it changes anything. */
inline bool moves(const FileOrigin& o) { return o.x_m != 0 || o.y_m != 0 || o.z_m != 0; }

}  // namespace talus::formats
