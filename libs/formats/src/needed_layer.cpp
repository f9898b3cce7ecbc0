#include "needed_layer.h"

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

}  // namespace talus::formats
