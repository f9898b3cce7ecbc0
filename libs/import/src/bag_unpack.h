#pragma once
#include <cstddef>
#include <cstdint>
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

/** Bytes that packed ones may unpack to: a message of some KB must not take the memory of
 * the machine, and the cloud of a scanner that sees nothing packs very well. */
std::size_t most_unpacked(std::uint64_t packed_bytes);

struct UnpackedSize
{
  std::optional<std::size_t> expected;  //!< what must come out; without: what comes up to the end
  std::size_t most = 0;  //!< more is an error
  bool is_cut = false;  //!< the packed data are: what comes out of them will do
};

/** Unpacks one frame into `out`; memory grows with what comes out, not with what the data claims.
 * Throws std::runtime_error with what is wrong only. */
void unpack_bag_data(
    BagPacking packing, std::string_view packed, const UnpackedSize& size, std::vector<char>& out);

/** The same of LZ4 alone, up to `most` bytes; built without it: throws and names the package. */
void unpack_lz4(std::string_view packed, std::size_t most, bool is_cut, std::vector<char>& out);

/** Doubles `out` up to `most` bytes, after at least a few KiB. */
void grow(std::vector<char>& out, std::size_t most);

}  // namespace talus::import
