#pragma once
#include <talus/io/layer_stack.h>
#include <talus/layers.h>

#include <cmath>

namespace talus::test
{
/** A map of 60 x 40 cells: ground that rises to the east, a box of 0.5 m on 5 x 5 cells, ten
 * columns in the east of which nothing is known, and the southernmost row filled and not judged. */
inline io::LayerStack small_terrain()
{
  io::LayerStack s;
  s.cells_x = 60;
  s.cells_y = 40;
  s.resolution_m = 0.1;
  s.min_x_m = -1;
  s.min_y_m = 2;
  const auto layer = [&](Layer l) -> std::vector<float>&
  {
    s.names.emplace_back(layer_name(l));
    return s.layers.emplace_back();
  };
  s.layers.reserve(4);
  auto& traversability = layer(Layer::Traversability);
  auto& ground = layer(Layer::GroundElevation);
  auto& elevation = layer(Layer::Elevation);
  auto& state = layer(Layer::State);
  for (int iy = 0; iy < s.cells_y; ++iy)
    for (int ix = 0; ix < s.cells_x; ++ix)
    {
      const bool known = ix < 50, filled = iy == 0;
      const bool box = ix >= 20 && ix < 25 && iy >= 10 && iy < 15;
      const float z = 1.0F + 0.01F * static_cast<float>(ix);
      traversability.push_back(!known || filled ? NAN : box ? 0.0F : 0.8F);
      ground.push_back(known ? z : NAN);
      elevation.push_back(known ? (box ? z + 0.5F : z) : NAN);
      state.push_back(static_cast<float>(
          !known   ? CellState::Unknown
          : filled ? CellState::FilledOneSided
                   : CellState::Measured));
    }
  return s;
}

constexpr int kSmallTerrainBox = 25, kSmallTerrainJudged = 50 * 39;  //!< cells
/** Between its cells; of the box the tops, its sides, and the steps between tops that rise. */
constexpr int kSmallTerrainFaces = 2 * (49 * 39 + kSmallTerrainBox + 20 + 20);

}  // namespace talus::test
