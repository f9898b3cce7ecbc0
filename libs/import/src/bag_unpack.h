#pragma once
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace talus::import
{
enum class BagPacking
{
  None,
  Zstd,
  Lz4
};

bool is_zstd(std::string_view data);

/** Unpacks one frame into `out`; memory grows with what comes out, not with what the data claims.
 * `size`: what must come out; without: up to the end of the frame, no more than kMostBagBytes.
 * Throws std::runtime_error with what is wrong only. */
void unpack_bag_data(
    BagPacking packing, std::string_view packed, std::optional<std::size_t> size,
    std::vector<char>& out);

/** The same of LZ4 alone; built without it: throws and names the package. */
void unpack_lz4(std::string_view packed, std::size_t size, std::vector<char>& out);

/** Doubles `out` up to `most` bytes, after at least a few KiB. */
void grow(std::vector<char>& out, std::size_t most);

}  // namespace talus::import
