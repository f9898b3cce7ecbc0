#include "needed_layer.h"

#include <talus/layers.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::formats
{
namespace
{
enum class Join
{
  Mean,
  Least,
  Greatest
};

Join join_of(const std::string& layer)
{
  if (layer == layer_name(Layer::GroundElevation)) return Join::Mean;
  for (const Layer least : {Layer::Traversability, Layer::Sparsity, Layer::State})
    if (layer == layer_name(least)) return Join::Least;  // state 1 is measured
  return Join::Greatest;
}

/** Of the known values among four. */
class Joined
{
 public:
  void add(float v)
  {
    if (std::isnan(v)) return;
    sum_ += v;
    least_ = std::min(least_, v);
    greatest_ = std::max(greatest_, v);
    ++count_;
  }
  float as(Join join) const
  {
    if (count_ == 0) return std::numeric_limits<float>::quiet_NaN();
    if (join == Join::Mean) return sum_ / static_cast<float>(count_);
    return join == Join::Least ? least_ : greatest_;
  }

 private:
  float sum_ = 0, least_ = std::numeric_limits<float>::infinity(), greatest_ = -least_;
  int count_ = 0;
};

/** 0 is unknown among states, and no best one. */
float value_of(float v, bool is_state)
{
  return is_state && v == 0 ? std::numeric_limits<float>::quiet_NaN() : v;
}

std::vector<float> joined_layer(
    const io::LayerStack& map, const std::string& name, const std::vector<float>& from,
    const io::LayerStack& to)
{
  const bool is_state = name == layer_name(Layer::State);
  const Join join = join_of(name);
  std::vector<float> layer;
  layer.reserve(static_cast<std::size_t>(to.cells_x) * static_cast<std::size_t>(to.cells_y));
  for (int iy = 0; iy < to.cells_y; ++iy)
    for (int ix = 0; ix < to.cells_x; ++ix)
    {
      Joined four;
      for (int y = 2 * iy; y < std::min(2 * iy + 2, map.cells_y); ++y)
        for (int x = 2 * ix; x < std::min(2 * ix + 2, map.cells_x); ++x)
          four.add(value_of(from[static_cast<std::size_t>(y) * map.cells_x + x], is_state));
      const float v = four.as(join);
      layer.push_back(is_state && std::isnan(v) ? 0.0F : v);
    }
  return layer;
}
}  // namespace

io::LayerStack joined_cells(const io::LayerStack& map)
{
  io::LayerStack to;
  to.cells_x = (map.cells_x + 1) / 2;
  to.cells_y = (map.cells_y + 1) / 2;
  to.resolution_m = 2 * map.resolution_m;
  to.min_x_m = map.min_x_m;
  to.min_y_m = map.min_y_m;
  to.names = map.names;
  for (std::size_t i = 0; i < map.names.size(); ++i)
    to.layers.push_back(joined_layer(map, map.names[i], map.layers[i], to));
  return to;
}

}  // namespace talus::formats
