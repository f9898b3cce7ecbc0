#pragma once
#include <string>
#include <string_view>

namespace talus::import
{
/** Unpacks LZF, as binary_compressed .pcd files have it: exactly `size` bytes, else false. */
bool unpack_lzf(std::string_view packed, std::size_t size, std::string& out);

/** The most bytes that so many packed ones hold. */
constexpr std::size_t most_of_lzf(std::size_t packed_bytes)
{
  return packed_bytes * 88;  // three bytes give 264 at most
}

}  // namespace talus::import
