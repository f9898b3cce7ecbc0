#pragma once
#include "strips.h"
#include "seen_rays.h"

#include <talus/cell_record.h>
#include <talus/site/site.h>
#include <talus/site/traffic_map.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

// What scans hit above cells and passed through there, and whether it has moved.
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

/** Of scans, in the bins in which a cell was hit. */
struct Sums
{
  static constexpr int kPassesPerHit = 4;  //!< from here on what was hit has moved
  /** What was hit for longer in the mean of the square has come to stay: that rays passed there
   * before it came says nothing. */
  static constexpr double kStays_s = 3;
  /// @name What was hit for a moment, in the mean of the square, as a whole in one or two scans
  /// @{
  static constexpr double kMoment_s = 0.3;
  static constexpr int kPassesPerBriefHit = 3;
  /// @}

  int hits = 0, before = 0, later = 0;
  int cells = 0;  //!< that a scan hit
  double hit_s = 0;  //!< for how long, all together

  void add(const Sums& s)
  {
    hits += s.hits;
    before += s.before;
    later += s.later;
    cells += s.cells;
    hit_s += s.hit_s;
  }
  /** Whether rays passed there so much more often than it was hit. */
  bool passed(int passes_per_hit) const
  {
    const bool came_to_stay = hit_s > kStays_s * cells;
    return hits > 0 && later + (came_to_stay ? 0 : before) >= passes_per_hit * hits;
  }
  /** Whether what was hit there has moved. */
  bool moved() const
  {
    const bool brief = cells > 0 && hit_s <= kMoment_s * cells;
    return passed(brief ? kPassesPerBriefHit : kPassesPerHit);
  }
};

/** Those of the bins in which a cell was hit. Its top was hit at least once. */
inline Sums sums_of(const Column& c)
{
  Sums sums;
  sums.hits = c.stands() ? 1 : 0;
  if (!std::isnan(c.first_hit_s)) sums.cells = 1, sums.hit_s = c.last_hit_s - c.first_hit_s;
  for (int bin = 0; bin < Column::kBins; ++bin)
  {
    const auto b = static_cast<std::size_t>(bin);
    if (c.hits[b] == 0 && bin != c.top_bin) continue;
    sums.hits += c.hits[b];
    sums.before += c.before[b];
    sums.later += c.later[b];
  }
  return sums;
}

/** A tile and what is around it, and the sums of its cells. */
class Surroundings
{
 public:
  static constexpr double kAround_m = 1.3;  //!< side of the square over which sums are added

  Surroundings(const TileKey& key, double resolution_m)
      : key_(key),
        margin_(cells_of(kAround_m, resolution_m) / 2),
        side_(kTileCells + 2 * margin_),
        rect_{
            std::int64_t{key.x} * kTileCells - margin_, std::int64_t{key.y} * kTileCells - margin_,
            side_, side_},
        sums_(rect_.size())
  {
  }
  const CellRect& rect() const { return rect_; }
  void put(const Column& c) { sums_[c.at] = sums_of(c); }
  /** Of the square around a cell. */
  Sums sums_around(std::size_t at) const
  {
    Sums all;
    for_each_near(at, margin_, [&](std::size_t near) { all.add(sums_[near]); });
    return all;
  }
  /** Calls f(index) for the cells in a square around one. */
  template <class F>
  void for_each_near(std::size_t at, int radius, const F& f) const
  {
    const int x = x_of(at), y = y_of(at);
    for (int row = std::max(y - radius, 0); row <= std::min(y + radius, side_ - 1); ++row)
      for (int column = std::max(x - radius, 0); column <= std::min(x + radius, side_ - 1);
           ++column)
        f(static_cast<std::size_t>(row * side_ + column));
  }
  /** Calls f(key) for the tiles of the square. */
  template <class F>
  void for_each_tile(const F& f) const
  {
    site::for_each_tile(rect_, key_.floor, [&](const TilePart& part) { f(part.key); });
  }
  /** The tile of a cell in the square, and its index there. */
  std::pair<TileKey, int> in_tile(std::size_t at) const
  {
    const std::int64_t x = rect_.min_cell_x + x_of(at), y = rect_.min_cell_y + y_of(at);
    return {{key_.floor, tile_of(x), tile_of(y)}, index_in_tile(y) * kTileCells + index_in_tile(x)};
  }
  /** The index in the square of a cell of a tile. */
  std::optional<std::size_t> index_of(const TileKey& key, int cell) const
  {
    const std::int64_t x = cell_of_tile(key.x, cell % kTileCells) - rect_.min_cell_x;
    const std::int64_t y = cell_of_tile(key.y, cell / kTileCells) - rect_.min_cell_y;
    if (x < 0 || x >= side_ || y < 0 || y >= side_) return std::nullopt;
    return static_cast<std::size_t>(y * side_ + x);
  }

 private:
  static int cells_of(double length_m, double resolution_m)
  {
    return static_cast<int>(std::lround(length_m / resolution_m));
  }
  int x_of(std::size_t at) const { return static_cast<int>(at) % side_; }
  int y_of(std::size_t at) const { return static_cast<int>(at) / side_; }

  TileKey key_;
  int margin_, side_;
  CellRect rect_;
  std::vector<Sums> sums_;
};

}  // namespace talus::site
