#pragma once
#include <talus/map_view.h>

#include <string>
#include <vector>

namespace talus::io
{
/** Layers of one window with where they lie: what the writers of files and pictures take. Owns its
 * data. */
struct LayerStack
{
  /** Cells along x and y. */
  int cells_x = 0, cells_y = 0;
  /** Side of a cell [m]. */
  double resolution_m = 0;
  /** outer corner of cell (0,0), map frame */
  double min_x_m = 0, min_y_m = 0;
  /** Of the layers. */
  std::vector<std::string> names;
  /** One entry a name; each cells_x*cells_y floats, index = iy*cells_x + ix, iy grows with y
   * (north). NaN: unknown. */
  std::vector<std::vector<float>> layers;

  /** The layer of that name, or nullptr. */
  const std::vector<float>* find(const std::string& name) const;

  /** Throws std::runtime_error that says what is wrong unless there is a cell, a layer, a place in
   * the map frame, and one value a cell in each layer. */
  void require_sound() const;
};

/** All layers of a map, in the order of kLayerTable, then those of its channels. */
LayerStack snapshot(const MapView& map);

}  // namespace talus::io
