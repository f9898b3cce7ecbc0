#include "bands.h"

#include <talus/layers.h>
#include <talus/number_text.h>
#include <talus/io/layer_stack.h>

#include <cmath>
#include <iterator>
#include <stdexcept>

namespace talus::io
{
std::size_t index_of_band(const std::string& name)
{
  for (const Layer first : {Layer::Traversability, Layer::GroundElevation})
    if (name == layer_name(first)) return first == Layer::Traversability ? 0 : 1;
  const LayerInfo* known = find_layer(name);
  return 2 + (known ? static_cast<std::size_t>(known - kLayerTable) : std::size(kLayerTable));
}

const char* unit_of_band(const std::string& name)
{
  const LayerInfo* known = find_layer(name);
  return known ? known->unit : "";
}

std::map<std::string, std::string> BandStatistics::items(double cells) const
{
  if (count_ == 0) return {};
  return {
      {"STATISTICS_MINIMUM", exact_number_text(min_)},
      {"STATISTICS_MAXIMUM", exact_number_text(max_)},
      {"STATISTICS_MEAN", exact_number_text(mean_)},
      {"STATISTICS_STDDEV", exact_number_text(std::sqrt(squares_ / count_))},
      {"STATISTICS_VALID_PERCENT", fixed_text(100 * count_ / cells, 2)}};
}

std::map<std::string, std::string> band_items(
    const std::string& name, const BandStatistics& statistics, double cells)
{
  auto items = statistics.items(cells);
  if (const LayerInfo* known = find_layer(name); known && known->classes)
    items["TALUS_CLASSES"] = known->classes;
  return items;
}

const std::vector<float>* LayerStack::find(const std::string& name) const
{
  for (std::size_t i = 0; i < names.size() && i < layers.size(); ++i)
    if (names[i] == name) return &layers[i];
  return nullptr;
}

void LayerStack::require_sound() const
{
  if (cells_x <= 0 || cells_y <= 0 || layers.empty() || names.size() != layers.size())
    throw std::runtime_error("the map has no cells or layers");
  if (!(resolution_m > 0 && std::isfinite(resolution_m + min_x_m + min_y_m)))
    throw std::runtime_error("the map has no place: its resolution or corner is no number");
  const auto cells = static_cast<std::size_t>(cells_x) * static_cast<std::size_t>(cells_y);
  for (std::size_t i = 0; i < layers.size(); ++i)
    if (layers[i].size() != cells)
      throw std::runtime_error(
          "layer '" + names[i] + "' does not have " + std::to_string(cells_x) + " x " +
          std::to_string(cells_y) + " cells");
}

LayerStack snapshot(const MapView& map)
{
  const Window w = map.window();
  LayerStack stack;
  stack.cells_x = stack.cells_y = w.cells;
  stack.resolution_m = w.resolution_m;
  stack.min_x_m = w.min_x_m();
  stack.min_y_m = w.min_y_m();
  for (int i = 0; i < kLayerCount; ++i)
  {
    stack.names.emplace_back(kLayerTable[i].name);
    stack.layers.push_back(map.layer(static_cast<Layer>(i)));
  }
  for (const std::string& name : channel_layer_names(map.parameters().channels))
  {
    stack.names.push_back(name);
    stack.layers.push_back(map.channel(name));
  }
  return stack;
}

}  // namespace talus::io
