#pragma once
// How a layer of a snapshot becomes bytes, and back.
#include <talus/layers.h>

#include <cstdint>
#include <vector>

namespace talus::detail
{
/** Values in steps from an offset; 0xFFFF: NaN. */
struct PackedLayer
{
  double offset = 0, step = 1;
  std::vector<std::uint8_t> zlib;  //!< differences along the rows, low bytes then high bytes
};

PackedLayer pack_layer(Layer layer, const std::vector<float>& values);

/** Throws std::runtime_error when the bytes are not `count` values. */
std::vector<float> unpack_layer(Layer layer, const PackedLayer& packed, std::size_t count);

}  // namespace talus::detail
