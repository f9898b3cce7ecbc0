#pragma once
#include <talus/cell_record.h>
#include <talus/layers.h>
#include <talus/site/tile_store.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <vector>

// What is kept of one cell and its channels, and what the map says of it now.
namespace talus::site
{
inline CellState state_of(const CellRecord& c) { return static_cast<CellState>(c.state); }
inline bool is_known(const CellRecord& c) { return state_of(c) != CellState::Unknown; }
inline bool is_measured(const CellRecord& c) { return state_of(c) == CellState::Measured; }

/** Whether a known cell that was read from somewhere may be one of a map. */
inline bool is_sound(const CellRecord& c)
{
  constexpr float kHighest_m = 1e9f;  // beyond what frames can lead to
  const auto is_surface = [&](float height_m, float variance_m2)
  { return std::abs(height_m) <= kHighest_m && variance_m2 >= 0 && std::isfinite(variance_m2); };
  const bool has_no_top = std::isnan(c.elevation_m) && std::isnan(c.elevation_variance_m2);
  return c.state < kCellStates && is_surface(c.ground_m, c.ground_variance_m2) &&
         (has_no_top || is_surface(c.elevation_m, c.elevation_variance_m2)) &&
         (std::isnan(c.traversability) || (c.traversability >= 0 && c.traversability <= 1));
}

/** The nearest float with so few bits of mantissa that files of it are small. */
inline float rounded_bits(float v, int dropped_bits)
{
  std::uint32_t bits;
  std::memcpy(&bits, &v, sizeof bits);
  const std::uint32_t half = std::uint32_t{1} << (dropped_bits - 1);
  bits = (bits + half) & ~(2 * half - 1);
  std::memcpy(&v, &bits, sizeof bits);
  return v;
}

/// @name Steps of what a site keeps of a cell, and bits of mantissa that variances lose
/// @{
constexpr float kHeightsPerMetre = 1024, kScores = 256;
constexpr int kDroppedBits = 16, kDroppedChannelBits = 8;
/// @}

/** What a site keeps of a cell: heights in steps of 2^-10 m (1 mm), traversability in steps of
 * 1/256, of which only 0 becomes 0, and variances to 1 %. Measurements vary by more, and files are
 * a third smaller. */
inline CellRecord kept_of(CellRecord c)
{
  for (float* height_m : {&c.ground_m, &c.elevation_m})
    *height_m = std::round(*height_m * kHeightsPerMetre) / kHeightsPerMetre;  // NaN stays NaN
  for (float* variance_m2 : {&c.ground_variance_m2, &c.elevation_variance_m2})
    if (!std::isnan(*variance_m2)) *variance_m2 = rounded_bits(*variance_m2, kDroppedBits);
  if (c.traversability > 0)
    c.traversability = std::max(std::round(c.traversability * kScores), 1.0F) / kScores;
  clear_transient_evidence(c);
  return c;
}

/** Whether something is known to stand on the ground. */
inline bool has_top(const CellRecord& c) { return c.elevation_m > c.ground_m; }

/** Heights of two floors. */
inline bool contradict(float a_m, float b_m) { return std::abs(a_m - b_m) > kOtherFloor_m; }

/** How much is guessed of the ground: what was measured comes before what was filled from two
 * sides, what the robot stood on, and what was filled from one. */
inline int guessed_ground(const CellRecord& c)
{
  return state_of(c) == CellState::FilledOneSided ? kCellStates : c.state;
}
/** Whether no ray has proved the guess that it is: nobody saw anything there. */
inline bool is_unproved(const CellRecord& c)
{
  return state_of(c) == CellState::FilledOneSided && std::isnan(c.traversability) &&
         std::isnan(c.elevation_m);
}
/** The same of all: what was hit comes first. */
inline int guessed(const CellRecord& c)
{
  return std::isnan(c.elevation_m) ? guessed_ground(c) : static_cast<int>(CellState::Measured);
}

/** Whether two measurements differ by noise alone. */
inline bool agree(float a_m, float a_m2, float b_m, float b_m2)
{
  constexpr float kSigmas2 = 9;
  return (a_m - b_m) * (a_m - b_m) <= kSigmas2 * (a_m2 + b_m2);
}

/** Whether what was kept of a cell is worth more than what its first frame says. */
inline bool is_worth_more(const CellRecord& kept, const CellRecord& now)
{
  if (!is_known(kept)) return false;
  if (!is_known(now)) return true;
  if (guessed(kept) != guessed(now)) return guessed(kept) < guessed(now);
  return is_measured(kept) && is_measured(now) &&
         kept.ground_variance_m2 < now.ground_variance_m2 &&
         agree(kept.ground_m, kept.ground_variance_m2, now.ground_m, now.ground_variance_m2) &&
         agree(
             kept.elevation_m, kept.elevation_variance_m2, now.elevation_m,
             now.elevation_variance_m2);
}

/** Whether a cell's ground is as it was, but for noise, and something stands on it if it did. */
inline bool is_unchanged(const CellRecord& kept, const CellRecord& now)
{
  constexpr float kSame_m = 0.01f;
  return kept.state == now.state && std::abs(kept.ground_m - now.ground_m) < kSame_m &&
         std::isnan(kept.elevation_m) == std::isnan(now.elevation_m);
}

inline std::uint32_t whole_seconds(double stamp_s)
{
  constexpr double kMax = std::numeric_limits<std::uint32_t>::max();
  return stamp_s > 0 ? static_cast<std::uint32_t>(std::min(stamp_s, kMax)) : 0;  // not NaN
}

/** What a site keeps of a value of a channel: 16 bits of it, so that whole numbers up to 65536 stay
 * as they are, and others are off by 1/131072 of them at most. */
inline float kept_value(float v)
{
  return std::isnan(v) ? NAN : rounded_bits(v, kDroppedChannelBits);
}

/** What stood there has left. */
inline void forget_standing(ChannelRecord& values)
{
  for (std::size_t l = 1; l < std::size(values.values); l += kChannelSurfaces)
    values.values[l] = NAN;
}

/** Layers that are counted in another list of channels, see channel_indices(). */
inline void put_values(
    const ChannelTile& from, const std::vector<std::size_t>& places, ChannelTile& to)
{
  for (std::size_t i = 0; i < from.cells.size(); ++i)
    for (std::size_t l = 0; l < places.size(); ++l)
      to.cells[i].values[places[l]] = from.cells[i].values[l];
}

/** What several maps know of one cell, whose values have the same layers: of the ground the newest
 * that there are, of what stands there those of the newest map that has seen the place. Of maps of
 * the same second the greatest value. */
ChannelRecord merge_values(
    const std::vector<SiteCell>& cells, const std::vector<ChannelRecord>& values);

}  // namespace talus::site
