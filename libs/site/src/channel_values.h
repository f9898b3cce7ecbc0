#pragma once
#include "kept_cell.h"

#include <talus/site/tile_store.h>

#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

// The values of channels of a site.
namespace talus::site
{
/** What a site keeps of a value of a channel: 16 bits of it, so that whole numbers up to 65536 stay
 * as they are, and others are off by 1/131072 of them at most. */
inline float kept_value(float v)
{
  return std::isnan(v) ? NAN : rounded_bits(v, kDroppedChannelBits);
}

/** What stood there has left. */
inline void forget_standing(ChannelRecord& values)
{
  for (std::size_t l = 1; l < std::size(values.values); l += kChannelSurfaces)
    values.values[l] = NAN;
}

/** Layers that are counted in another list of channels, see channel_indices(). */
inline void put_values(
    const ChannelTile& from, const std::vector<std::size_t>& places, ChannelTile& to)
{
  for (std::size_t i = 0; i < from.cells.size(); ++i)
    for (std::size_t l = 0; l < places.size(); ++l)
      to.cells[i].values[places[l]] = from.cells[i].values[l];
}

/** What several maps know of one cell, whose values have the same layers: of the ground the newest
 * that there are, of what stands there those of the newest map that has seen the place. Of maps of
 * the same second the greatest value. */
ChannelRecord merge_values(
    const std::vector<SiteCell>& cells, const std::vector<ChannelRecord>& values);

}  // namespace talus::site
