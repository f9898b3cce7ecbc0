#include "needed_layer.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace talus::formats
{
const std::vector<float>& needed_layer(const io::LayerStack& map, Layer layer)
{
  map.require_sound();
  if (const auto* values = map.find(layer_name(layer))) return *values;
  throw std::runtime_error(
      std::string("the map has no layer '") + layer_name(layer) +
      "': give a map.tif or site.tif of talus-map, or a site of talus-merge");
}

void require_sound_cells(const io::LayerStack& map, const std::string& path)
{
  constexpr float kHighest_m = 1e6F, kLastState = kCellStates - 1;
  const auto require = [&](Layer layer, float least, float most, bool whole = false)
  {
    const auto* values = map.find(layer_name(layer));
    if (!values) return;
    for (const float v : *values)
      if (v < least || v > most || std::fpclassify(v) == FP_SUBNORMAL ||  // bytes in another order
          (whole && v != std::round(v) && !std::isnan(v)))
        throw std::runtime_error(
            path + ": its band '" + layer_name(layer) + "' has the value " + number_text(v) +
            ", which no map has: copy it again, or make it anew");
  };
  require(Layer::GroundElevation, -kHighest_m, kHighest_m);
  require(Layer::Elevation, -kHighest_m, kHighest_m);
  require(Layer::Traversability, 0, 1);
  require(Layer::State, 0, kLastState, true);
}

FileOrigin origin_for(const io::LayerStack& map)
{
  constexpr double kFar_m = 8192, kWhole_m = 1000;  // float32 has steps of 1 mm from there on
  const auto off = [&](double min_m, int cells)
  {
    const double max_m = min_m + cells * map.resolution_m;
    const bool is_far = std::max(std::abs(min_m), std::abs(max_m)) > kFar_m;
    if (!is_far) return 0.0;
    const double near_m = kWhole_m * std::round((min_m + max_m) / 2 / kWhole_m);
    const double cells_away = std::round((min_m - near_m) / map.resolution_m);
    return std::round((min_m - cells_away * map.resolution_m) * 1e6) / 1e6;
  };
  return {off(map.min_x_m, map.cells_x), off(map.min_y_m, map.cells_y), 0};
}

std::string text_of(const FileOrigin& origin)
{
  return number_text(origin.x_m) + " " + number_text(origin.y_m) + " " + number_text(origin.z_m);
}

}  // namespace talus::formats
