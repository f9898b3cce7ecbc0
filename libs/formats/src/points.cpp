#include <talus/formats/convert.h>

#include "needed_layer.h"

namespace talus::formats
{
void to_points(const io::LayerStack& map, Surface what, mrpt::maps::CPointsMap& out)
{
  const Heights h(map);
  const auto& state = needed_layer(map, Layer::State);
  const auto put = [&](int ix, int iy, double z_m)
  {
    out.insertPoint(
        static_cast<float>(middle_x_m(map, ix)), static_cast<float>(middle_y_m(map, iy)),
        static_cast<float>(z_m));
  };
  for_each_cell(
      map,
      [&](std::size_t i, int ix, int iy)
      {
        if (what == Surface::Ground && state[i] == static_cast<float>(CellState::Measured))
          put(ix, iy, h.ground[i]);
        if (what == Surface::Standing && h.stands(i))
          for (double z_m = h.top[i]; z_m > h.ground[i]; z_m -= map.resolution_m) put(ix, iy, z_m);
      });
}

}  // namespace talus::formats
