#include "layer_codec.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace talus::detail
{
namespace
{
constexpr std::uint16_t kNan = 0xFFFF;
constexpr double kHeightStep_m = 1.0 / 512, kScoreStep = 1.0 / 256, kMostSteps = 65000;

bool is_height(Layer l) { return l == Layer::Elevation || l == Layer::GroundElevation; }

double finest_step(Layer l)
{
  if (l == Layer::State) return 1;
  return is_height(l) || l == Layer::Variance ? kHeightStep_m : kScoreStep;
}

double to_stored(Layer l, double v) { return l == Layer::Variance ? std::sqrt(v) : v; }
double from_stored(Layer l, double v) { return l == Layer::Variance ? v * v : v; }

/** Sets offset and step so that every value fits. */
void choose_steps(Layer layer, const std::vector<float>& values, PackedLayer& p)
{
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const float v : values)
    if (std::isfinite(v))
    {
      low = std::min(low, to_stored(layer, v));
      high = std::max(high, to_stored(layer, v));
    }
  p.offset = is_height(layer) && low <= high ? std::floor(low) : 0;
  p.step = std::max(finest_step(layer), (high - p.offset) / kMostSteps);
}

std::uint16_t steps_of(Layer layer, float value, const PackedLayer& p)
{
  if (!std::isfinite(value)) return kNan;
  const double q = std::round((to_stored(layer, value) - p.offset) / p.step);
  // A score or a variance above 0 must not become 0.
  const double least = !is_height(layer) && value > 0 ? 1 : 0;
  return static_cast<std::uint16_t>(std::clamp(q, least, kMostSteps));
}

std::vector<std::uint8_t> compressed(const std::vector<std::uint8_t>& bytes)
{
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::uint8_t> out(size);
  if (compress2(out.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), 6) != Z_OK)
    throw std::runtime_error("talus::CObservationTraversability: a layer cannot be compressed");
  out.resize(size);
  return out;
}
}  // namespace

PackedLayer pack_layer(Layer layer, const std::vector<float>& values)
{
  PackedLayer p;
  choose_steps(layer, values, p);
  const std::size_t n = values.size();
  std::vector<std::uint8_t> bytes(2 * n);
  std::uint16_t before = 0;
  for (std::size_t i = 0; i < n; i++)
  {
    const std::uint16_t q = steps_of(layer, values[i], p);
    const auto difference = static_cast<std::uint16_t>(q - before);
    bytes[i] = static_cast<std::uint8_t>(difference & 0xFF);
    bytes[n + i] = static_cast<std::uint8_t>(difference >> 8);
    before = q;
  }
  p.zlib = compressed(bytes);
  return p;
}

std::vector<float> unpack_layer(Layer layer, const PackedLayer& p, std::size_t count)
{
  std::vector<std::uint8_t> bytes(2 * count);
  auto size = static_cast<uLongf>(bytes.size());
  const auto packed = static_cast<uLong>(p.zlib.size());
  if (uncompress(bytes.data(), &size, p.zlib.data(), packed) != Z_OK || size != bytes.size())
    throw std::runtime_error(
        "talus::CObservationTraversability: the stream is damaged (layer " +
        std::string(layer_name(layer)) + ")");
  std::vector<float> values(count);
  std::uint16_t q = 0;
  for (std::size_t i = 0; i < count; i++)
  {
    q = static_cast<std::uint16_t>(q + bytes[i] + 256 * bytes[count + i]);
    values[i] = q == kNan ? std::numeric_limits<float>::quiet_NaN()
                          : static_cast<float>(from_stored(layer, p.offset + q * p.step));
  }
  return values;
}

}  // namespace talus::detail
