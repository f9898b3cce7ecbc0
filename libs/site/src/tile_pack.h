#pragma once
#include <talus/site/tile_store.h>

#include <cstdint>
#include <vector>

namespace talus::site
{
/** A tile in a fifth of its memory or less, for the time in which nothing needs it. Of each run of
 * cells every value is stored as its difference from the least one, in as few bits as the largest
 * difference takes: heights as the whole number of steps to which a site rounds them, variances
 * without the bits that it drops. What was not rounded takes all its bits. */
std::vector<std::uint8_t> packed(const Tile& tile);

/** The same of the values of channels: whole numbers, and what kept_value() left, in the fewest
 * bits. */
std::vector<std::uint8_t> packed(const ChannelTile& tile);

/** And back, bit for bit. */
void unpack(const std::vector<std::uint8_t>& bytes, Tile& tile);
void unpack(const std::vector<std::uint8_t>& bytes, ChannelTile& tile);

}  // namespace talus::site
