#include <talus/io/layer_stack.h>

namespace talus::io
{
const std::vector<float>* LayerStack::find(const std::string& name) const
{
  for (std::size_t i = 0; i < names.size() && i < layers.size(); ++i)
    if (names[i] == name) return &layers[i];
  return nullptr;
}

LayerStack snapshot(const ElevationMapper& map)
{
  const Window w = map.window();
  LayerStack stack;
  stack.cells_x = stack.cells_y = w.cells;
  stack.resolution_m = w.resolution_m;
  stack.min_x_m = w.min_x_m();
  stack.min_y_m = w.min_y_m();
  for (int i = 0; i < kLayerCount; ++i)
  {
    stack.names.emplace_back(kLayerNames[i]);
    stack.layers.push_back(map.layer(static_cast<Layer>(i)));
  }
  return stack;
}

}  // namespace talus::io
