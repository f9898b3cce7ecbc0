#pragma once
// How a layer of a snapshot becomes bytes, and back.
#include <talus/layers.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace talus::detail
{
/** Values in steps from an offset; 0xFFFF: NaN. */
struct PackedLayer
{
  double offset = 0, step = 1;
  std::size_t count = 0;  //!< of values
  std::vector<std::uint8_t> zlib;  //!< differences along the rows, low bytes then high bytes
};

PackedLayer pack_layer(Layer layer, const std::vector<float>& values);

/** Whether these may be `count` values of a layer, as far as that can be told without unpacking
 * them. */
bool is_plausible(const PackedLayer& packed);

/** Takes some values, those behind the ones that it took before. */
using TakeValues = std::function<void(const float* values, std::size_t count)>;

/** Unpacks a layer in pieces, each of them for `take`: little memory, whatever `count` says. What
 * no cell of such a layer can have is NaN. Throws std::runtime_error when the bytes are not `count`
 * values. */
void unpack_layer(Layer layer, const PackedLayer& packed, const TakeValues& take);

}  // namespace talus::detail
