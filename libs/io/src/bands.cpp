#include "bands.h"

#include <talus/layers.h>
#include <talus/number_text.h>

#include <cmath>
#include <iterator>

namespace talus::io
{
std::size_t place_of_band(const std::string& name)
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

}  // namespace talus::io
