#pragma once
#include "seen_rays.h"

#include <talus/cell_record.h>
#include <talus/site/site.h>
#include <talus/site/traffic_map.h>

#include <array>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

// What scans hit above cells, and what they passed through there.
namespace talus::site
{
/** Which of the last scans hit something, by their number. */
using HitScans = std::bitset<128>;

/** A cell: how many scans hit something above it, and how many passed through it before it was hit
 * first, and later, in bins of height above its ground. Lower things are judged by what is around
 * them. */
struct Column
{
  static constexpr int kBins = 16, kNoBin = -1;
  static constexpr float kLowest_m = 0.2F, kBin_m = 0.1F;

  std::size_t at = 0;  //!< in the rectangle of cells
  double x_m = 0, y_m = 0;
  float low_m = 0;
  int top_bin = kNoBin;  //!< of what stands there
  std::array<std::uint16_t, kBins> hits{}, before{}, later{};
  double first_hit_s = NAN, last_hit_s = NAN;
  HitScans when;
  TrafficCell recent;  //!< of the scans that were not noted before

  bool stands() const { return top_bin != kNoBin; }
};

/** Which cells have a column. */
enum class Which
{
  Standing,  //!< those on which something stands
  All  //!< those with a ground
};

/** The columns of a rectangle of cells of a floor. Scans are recent after a time. */
std::vector<Column> count_columns(
    Site& site, const CellRect& cells, int floor, Which which, const Scans& scans, double recent_s);

}  // namespace talus::site
