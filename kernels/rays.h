#pragma once
#include "kernels/config.h"
#include "kernels/lines.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"

namespace talus::kernels
{
// The rays of a frame in square polar coordinates around the sensor. A "ring" is the Chebyshev
// distance in cells, a direction is a position on the border of a square. All directions are alike,
// a row of the table is one ring, and a sweep along the rings visits each cell O(1) times.

/** Bins along a side of the square: a bin is as wide as a cell at the window's border. */
TALUS_HD int bins_per_side(const Config& k) { return k.cells; }
TALUS_HD int bin_count(const Config& k) { return 4 * bins_per_side(k); }
/** Room for rings in the table, for a sensor up to a sixteenth of the window away from its middle.
 * FrameContext::rings are in use; the last one holds all hits beyond. */
TALUS_HD int most_rings(int cells) { return cells / 2 + cells / 16 + 3; }

/** Direction of (dx, dy) != 0 along the square's border, counter-clockwise, in [0, bin_count]. */
TALUS_HD float direction_in_bins(float dx, float dy, int per_side)
{
  const bool along_x = abs_of(dx) >= abs_of(dy);
  const float u = select(along_x, dy, -dx) / select(along_x, dx, dy);
  const int side = select(along_x, select(dx > 0.0f, 0, 2), select(dy > 0.0f, 1, 3));
  const float size = static_cast<float>(per_side);
  return (u + 1.0f) * (0.5f * size) + static_cast<float>(side * per_side);
}

/** Vector of unit Chebyshev length through the middle of a bin. */
struct BinDirection
{
  float x, y;
};

TALUS_HD BinDirection direction_of_bin(int bin, int per_side)
{
  const float u =
      (static_cast<float>(bin % per_side) + 0.5f) * 2.0f / static_cast<float>(per_side) - 1.0f;
  switch (bin / per_side)
  {
    case 0:
      return {1.0f, u};
    case 1:
      return {-u, 1.0f};
    case 2:
      return {-1.0f, -u};
    default:
      return {u, -1.0f};
  }
}

TALUS_HD int wrap_bin(int bin, int count)
{
  return bin + select(bin < 0, count, 0) - select(bin >= count, count, 0);
}

TALUS_HD float chebyshev(float dx, float dy)
{
  const float x = abs_of(dx), y = abs_of(dy);
  return select(x < y, y, x);
}

/** Slope of the ray from the sensor to a point, per metre of Chebyshev distance. */
TALUS_HD float ray_slope(float dz, float chebyshev_m) { return dz / chebyshev_m; }

constexpr std::int32_t kNoRay = 0x7fffffff;

/** The last bits of a ray say where it ended: the bits of that Chebyshev distance from 0.5 to 128
 * m in 128 steps for each doubling. Its slope keeps 13 bits, which is exact to 1 mm. */
constexpr std::int32_t kEndBits = 1023;
constexpr std::uint32_t kNearestEnd = 0x3f00;  //!< upper half of 0.5f

/** A ray as an ordered integer: of two the lower is less. */
TALUS_HD std::int32_t ray_of(float slope, float end_m)
{
  const float end = min_of(max_of(end_m, 0.5f), 127.5f);
  const auto bits = static_cast<std::int32_t>((bits_of(end) >> 16) - kNearestEnd);
  return (ordered_from_float(slope) & ~kEndBits) | bits;
}
/** Where it ended, or up to a 128th nearer. */
TALUS_HD float end_of_ray_m(std::int32_t ray)
{
  return float_of_bits((static_cast<std::uint32_t>(ray & kEndBits) + kNearestEnd) << 16);
}

constexpr int kSlopeBins = 64;  //!< the number of bins of slope
/** Slopes are bent into [-1, 1]; the bins cover -1/2 (slope -1) to 1/4 (slope 1/3). */
constexpr float kLowestBent = -0.5f, kBentRange = 0.75f;
/** The bin of a slope, with its fraction. Level slopes have the finest bins, for they reach
 * farthest. Steep ones are outside [0, kSlopeBins). */
TALUS_HD float slope_bin(float slope)
{
  const float bent = slope / (1.0f + abs_of(slope));
  return (bent - kLowestBent) * (static_cast<float>(kSlopeBins) / kBentRange);
}
/** The slope at a bin with its fraction. */
TALUS_HD float slope_at_bin(float bin)
{
  const float bent = kLowestBent + bin * (kBentRange / static_cast<float>(kSlopeBins));
  return bent / (1.0f - abs_of(bent));
}
/** The slope in the middle of a bin. */
TALUS_HD float slope_of_bin(int bin) { return slope_at_bin(static_cast<float>(bin) + 0.5f); }

/** How far gentle ground falls on a path of this length. */
TALUS_HD float gentle_fall_m(float length_m)
{
  const float hill_m = kEndsFarFall * length_m + (kEndsFall - kEndsFarFall);
  return max_of(kEndsFall * length_m, min_of(hill_m, kHill_m));
}
/** Whether rays pass above the ground at a height; infinity: no ray. Rays below it show an object
 * or a drop, unless others pass above it on both sides: a glossy floor reflects single rays. */
TALUS_HD bool passes_over(float height_m, float ground_m)
{
  return (height_m > ground_m) & (height_m < kInfinity);
}
/** Whether over(d) holds on both sides of a cell, within kBesideRay_cells. */
template <class Over>
TALUS_HD bool on_both_sides(const Over& over)
{
  bool left = false, right = false;
  for (int d = 1; d <= kBesideRay_cells && !(left && right); d++)
    left |= over(-d), right |= over(d);
  return left & right;
}
/** The same of rays above a height beside an index of a line, `aside` rows from the middle one, at
 * which Map::free_above_m is given. Rows are `across` apart. */
TALUS_HD bool is_passed_over(
    const float* free_above_m, int across, int aside, int rings, float ground_m)
{
  return on_both_sides(
      [&](int d)
      {
        const int row = aside + d;
        return abs_of(row) <= rings && passes_over(free_above_m[row * across], ground_m);
      });
}

}  // namespace talus::kernels
