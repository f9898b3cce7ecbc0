#pragma once
#include <talus/live_map.h>

namespace talus
{
/** What a map says, be it an ElevationMapper or a MapSnapshot, to those who only read. Converts
 * from both; valid as long as what it was made from. */
class MapView
{
 public:
  MapView(const ElevationMapper& map) : map_(&map) {}
  MapView(const MapSnapshot& snapshot) : snapshot_(&snapshot) {}

  bool empty() const { return map_ && map_->empty(); }
  Window window() const { return map_ ? map_->window() : snapshot_->window; }
  const Parameters& parameters() const { return map_ ? map_->parameters() : snapshot_->parameters; }
  /** Throws as MapSnapshot::layer() does. */
  const std::vector<float>& layer(Layer l) const
  {
    return map_ ? map_->layer(l) : snapshot_->layer(l);
  }

 private:
  const ElevationMapper* map_ = nullptr;
  const MapSnapshot* snapshot_ = nullptr;
};

}  // namespace talus
