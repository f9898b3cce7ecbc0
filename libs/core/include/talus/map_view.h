#pragma once
#include <talus/live_map.h>

#include <limits>
#include <string>
#include <vector>

namespace talus
{
/** Read access to an ElevationMapper or a MapSnapshot, which convert to it, while they live. */
class MapView
{
 public:
  /** A view of the current state of a map. */
  MapView(const ElevationMapper& map) : map_(&map) {}
  /** A view of a snapshot. */
  MapView(const MapSnapshot& snapshot) : snapshot_(&snapshot) {}

  /** True for a map without a frame; false for a snapshot. */
  bool empty() const { return map_ && map_->empty(); }
  /** Position of the cells of layer(). */
  Window window() const { return map_ ? map_->window() : snapshot_->window; }
  /** The parameters of the map. */
  const Parameters& parameters() const { return map_ ? map_->parameters() : snapshot_->parameters; }
  /** Throws as MapSnapshot::layer() does. */
  const std::vector<float>& layer(Layer l) const
  {
    return map_ ? map_->layer(l) : snapshot_->layer(l);
  }

  /** Throws as ElevationMapper::channel() does. */
  const std::vector<float>& channel(const std::string& name) const
  {
    return map_ ? map_->channel(name) : snapshot_->channel(name);
  }

  /** Value of a layer at a position of the map frame [m]. NaN outside of the window and where the
   * map knows nothing. Throws as layer(). */
  float at(Layer l, double x_m, double y_m) const { return value_at(layer(l), x_m, y_m); }
  /** The same of a layer of a channel. Throws as channel(). */
  float at(const std::string& channel_layer, double x_m, double y_m) const
  {
    return value_at(channel(channel_layer), x_m, y_m);
  }

 private:
  float value_at(const std::vector<float>& values, double x_m, double y_m) const
  {
    const auto i = window().index_at(x_m, y_m);
    return i && *i < values.size() ? values[*i] : std::numeric_limits<float>::quiet_NaN();
  }

  const ElevationMapper* map_ = nullptr;
  const MapSnapshot* snapshot_ = nullptr;
};

}  // namespace talus
