#pragma once
#include <talus/site/tile_store.h>

#include <cstdint>
#include <vector>

namespace talus::site
{
/** The known cells of a tile, compressed; the same for the same cells. */
std::vector<std::uint8_t> bytes_of(const Tile& tile);

/** And back. Throws std::invalid_argument where these are no cells of a map. */
void read_tile(const std::vector<std::uint8_t>& bytes, Tile& tile);

}  // namespace talus::site
