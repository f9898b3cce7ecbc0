#pragma once
#include <talus/io/layer_stack.h>

namespace talus::formats
{
/** A map with 2 x 2 cells joined into one: the mean of known heights, the least traversability and
 * sparsity, the greatest of all else. Its cells lie at whole multiples of their size from the
 * corner of `map`. */
io::LayerStack joined_cells(const io::LayerStack& map);

/** A map with its cells joined until fits(map) holds: itself, or `coarse`, which this fills. */
template <class F>
const io::LayerStack& joined_until(const F& fits, const io::LayerStack& map, io::LayerStack& coarse)
{
  const io::LayerStack* shown = &map;
  while (!fits(*shown))
  {
    coarse = joined_cells(*shown);
    shown = &coarse;
  }
  return *shown;
}

}  // namespace talus::formats
