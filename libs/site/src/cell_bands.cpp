#include "cell_bands.h"

#include "kept_cell.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace talus::site
{
namespace
{
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint32_t kExact = 1U << 24;  //!< whole numbers up to it are float32

/** The largest float32 that is not above a whole number. */
std::uint32_t floor_to_float(std::uint32_t whole)
{
  std::uint32_t step = 1;
  while (whole / step >= kExact) step *= 2;
  return whole / step * step;
}

/** NaN of any bits becomes one. */
float canonical(float v) { return std::isnan(v) ? kNone : v; }

/** A whole number from 0 to `max`. */
std::optional<std::uint32_t> whole(float v, std::uint32_t max)
{
  if (!(v >= 0 && static_cast<double>(v) <= max && v == std::floor(v))) return std::nullopt;
  return static_cast<std::uint32_t>(v);
}
}  // namespace

std::array<float, kKeptLayers.size()> kept_values(const CellRecord& c)
{
  return {canonical(c.traversability), canonical(c.ground_m),
          canonical(c.elevation_m),    canonical(c.ground_variance_m2),
          static_cast<float>(c.state), !is_known(c) ? kNone : is_reached(c) ? 1.0F : 0.0F};
}

BandValues values_of(const SiteCell& cell, std::uint32_t newest_s)
{
  BandValues values;
  values.fill(kNone);
  if (!cell.known()) return values;
  const CellRecord& c = cell.cell;
  const auto kept = kept_values(c);
  std::copy(kept.begin(), kept.end(), values.begin());
  const std::uint32_t age_s = newest_s - cell.seen_s, kept_s = floor_to_float(age_s);
  const auto put = [&](Band b, float v) { values[static_cast<std::size_t>(b)] = v; };
  const auto pack = [](std::uint32_t low, std::uint32_t middle, std::uint32_t high)
  { return static_cast<float>(low | middle << 8 | high << 16); };
  put(Band::Age, static_cast<float>(kept_s));
  put(Band::ElevationVariance, canonical(c.elevation_variance_m2));
  static_assert(CellRecord::kLastingBytes == 5);
  put(Band::Evidence, pack(c.evidence[0], c.evidence[1], c.evidence[2]));
  put(Band::Shape, pack(c.evidence[3], c.evidence[4], age_s - kept_s));
  return values;
}

void TileSum::add(const float* bands, std::size_t count)
{
  const auto mix = [this](std::uint64_t v)
  {
    const std::uint64_t mixed = (sum_ ^ v) * 0x9E3779B97F4A7C15U;
    sum_ = mixed << 29 | mixed >> 35;
  };
  ++cell_;
  const float state = bands[static_cast<std::size_t>(Band::State)];
  if (std::isnan(state) || state == 0) return;
  mix(cell_);
  for (std::size_t b = 0; b < count; ++b)
  {
    if (b == static_cast<std::size_t>(Band::Reached)) continue;  // in the evidence, too
    std::uint32_t bits = 0;
    std::memcpy(&bits, bands + b, sizeof bits);
    mix(bits);
  }
}

std::optional<SiteCell> cell_of(const BandValues& values, std::uint32_t newest_s)
{
  const auto of = [&](Band b) { return values[static_cast<std::size_t>(b)]; };
  SiteCell cell;
  if (std::isnan(of(Band::State)) || of(Band::State) == 0) return cell;
  const auto state = whole(of(Band::State), kCellStates - 1), age = whole(of(Band::Age), newest_s),
             evidence = whole(of(Band::Evidence), kExact - 1),
             shape = whole(of(Band::Shape), kExact - 1);
  if (!state || !age || !evidence || !shape || newest_s - *age < *shape >> 16) return std::nullopt;
  CellRecord& c = cell.cell;
  c.ground_m = of(Band::GroundElevation);
  c.ground_variance_m2 = of(Band::Variance);
  c.elevation_m = canonical(of(Band::Elevation));
  c.elevation_variance_m2 = canonical(of(Band::ElevationVariance));
  c.traversability = canonical(of(Band::Traversability));
  c.state = static_cast<std::uint8_t>(*state);
  for (int byte = 0; byte < CellRecord::kLastingBytes; byte++)
  {
    const std::uint32_t from = byte < 3 ? *evidence >> 8 * byte : *shape >> 8 * (byte - 3);
    c.evidence[byte] = static_cast<std::uint8_t>(from);
  }
  cell.seen_s = newest_s - *age - (*shape >> 16);
  return is_sound(c) ? std::optional<SiteCell>(cell) : std::nullopt;
}

}  // namespace talus::site
