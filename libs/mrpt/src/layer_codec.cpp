#include "layer_codec.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

namespace talus::detail
{
namespace
{
constexpr std::uint16_t kNan = 0xFFFF;
constexpr double kHeightStep_m = 1.0 / 512, kScoreStep = 1.0 / 256, kMaxSteps = 65000;
constexpr double kFarthest = 2e9;  // no value of a map is so far from 0
constexpr std::size_t kPieceBytes = 1 << 14;
constexpr std::size_t kMaxRatio = 1032;  // of zlib: 258 bytes in two bits

bool is_height(Layer l) { return layer_info(l).kind == LayerKind::Height; }
bool is_variance(Layer l) { return layer_info(l).kind == LayerKind::Variance; }
bool is_state(Layer l) { return layer_info(l).kind == LayerKind::State; }

double finest_step(Layer l)
{
  if (is_state(l)) return 1;
  return is_height(l) || is_variance(l) ? kHeightStep_m : kScoreStep;
}

double to_stored(Layer l, double v) { return is_variance(l) ? std::sqrt(v) : v; }
double from_stored(Layer l, double v) { return is_variance(l) ? v * v : v; }

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
  p.step = std::max(finest_step(layer), (high - p.offset) / kMaxSteps);
}

std::uint16_t steps_of(Layer layer, float value, const PackedLayer& p)
{
  if (!std::isfinite(value)) return kNan;
  const double q = std::round((to_stored(layer, value) - p.offset) / p.step);
  // A score or a variance above 0 must not become 0.
  const double min_steps = !is_height(layer) && value > 0 ? 1 : 0;
  return static_cast<std::uint16_t>(std::clamp(q, min_steps, kMaxSteps));
}

/** Steps of the greatest value that a cell can have. */
double max_steps_of(Layer l, const PackedLayer& p)
{
  if (is_state(l)) return static_cast<double>(CellState::Presumed);
  return is_height(l) || is_variance(l) ? kMaxSteps : std::round(1 / p.step);
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

[[noreturn]] void fail(Layer layer)
{
  throw std::runtime_error(
      std::string("talus::CObservationTraversability: the layer ") + layer_name(layer) +
      " is damaged; take another copy of the log or write it anew");
}

/** Unpacks bytes from the first on, as many at a time as one asks for. */
class Inflater
{
 public:
  /** The bytes must stay where they are. */
  Inflater(Layer layer, const std::vector<std::uint8_t>& zlib) : layer_(layer)
  {
    stream_.next_in = const_cast<Bytef*>(zlib.data());  // zlib does not write there
    stream_.avail_in = static_cast<uInt>(zlib.size());
    if (inflateInit(&stream_) != Z_OK) throw std::bad_alloc();
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /** Throws std::runtime_error where there are not so many. */
  void read(std::uint8_t* out, std::size_t count)
  {
    stream_.next_out = out;
    stream_.avail_out = static_cast<uInt>(count);
    while (stream_.avail_out > 0)
      if (inflate(&stream_, Z_NO_FLUSH) != Z_OK && stream_.avail_out > 0) fail(layer_);
  }

  /** No byte is left, and the checksum is that of those that were read. */
  bool is_at_end()
  {
    std::uint8_t further;
    stream_.next_out = &further;
    stream_.avail_out = 1;
    return inflate(&stream_, Z_NO_FLUSH) == Z_STREAM_END && stream_.avail_out == 1;
  }

 private:
  Layer layer_;
  z_stream stream_{};
};
}  // namespace

PackedLayer pack_layer(Layer layer, const std::vector<float>& values)
{
  PackedLayer p;
  choose_steps(layer, values, p);
  const std::size_t n = p.count = values.size();
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

bool is_plausible(const PackedLayer& p)
{
  const double last = p.offset + kMaxSteps * p.step;
  return p.step > 0 && std::abs(p.offset) <= kFarthest && last <= kFarthest &&
         2 * p.count <= kMaxRatio * p.zlib.size();
}

void unpack_layer(Layer layer, const PackedLayer& p, const TakeValues& take)
{
  // One goes through the low bytes, the other through the high ones.
  Inflater low(layer, p.zlib), high(layer, p.zlib);
  std::vector<std::uint8_t> low_bytes(kPieceBytes), high_bytes(kPieceBytes);
  std::vector<float> values(kPieceBytes);
  for (std::size_t left = p.count; left > 0;)
  {
    const std::size_t n = std::min(left, kPieceBytes);
    high.read(high_bytes.data(), n);
    left -= n;
  }
  const double max_steps = max_steps_of(layer, p);
  std::uint16_t q = 0;
  for (std::size_t left = p.count; left > 0;)
  {
    const std::size_t n = std::min(left, kPieceBytes);
    low.read(low_bytes.data(), n);
    high.read(high_bytes.data(), n);
    for (std::size_t i = 0; i < n; i++)
    {
      q = static_cast<std::uint16_t>(q + low_bytes[i] + 256 * high_bytes[i]);
      values[i] = q == kNan || q > max_steps
                      ? std::numeric_limits<float>::quiet_NaN()
                      : static_cast<float>(from_stored(layer, p.offset + q * p.step));
    }
    take(values.data(), n);
    left -= n;
  }
  if (!high.is_at_end()) fail(layer);
}

}  // namespace talus::detail
