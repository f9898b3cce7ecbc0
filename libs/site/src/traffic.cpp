#include "traffic.h"

#include "cell_evidence.h"
#include "judge_anew.h"
#include "kept_cell.h"
#include "strips.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace talus::site
{
namespace
{
/// @name Bins of height above the ground of a cell; lower things are judged by what is around them
/// @{
constexpr int kBins = 16;
constexpr int kNoBin = -1;
constexpr float kLowest_m = 0.2F, kBin_m = 0.1F;
/// @}
/// @name A ray hits a cell, or has passed it, if it ends so near to it, or so far behind it
/// @{
constexpr float kHit_cells = 1, kPassed_cells = 3;
/// @}
constexpr double kAround_m = 1.3;  //!< side of the square over which hits and passes are summed
constexpr int kPassesPerHit = 4;  //!< from so many on what was hit has moved
/** What was hit for longer in the mean of the square has come to stay: that rays passed there
 * before it came tells nothing. */
constexpr double kStays_s = 3;
constexpr double kVisit_s = 3;  //!< what is hit after such a pause is another visit

/** A cell: how many scans hit something above it, and how many passed through it before it was hit
 * first, and later, in each bin. */
struct Column
{
  std::size_t at = 0;  //!< in the rectangle of cells
  double x_m = 0, y_m = 0;
  float low_m = 0;
  int top_bin = kNoBin;  //!< of what stands there
  std::array<std::uint16_t, kBins> hits{}, before{}, later{};
  double first_hit_s = NAN, last_hit_s = NAN;
  TrafficCell recent;  //!< of the scans that were not noted before
};
enum class Which
{
  Standing,  //!< cells on which something stands
  All  //!< those with a ground
};

std::uint32_t bit(int bin) { return bin >= 0 && bin < kBins ? 1U << bin : 0; }
int bin_of(float height_m, const Column& c)
{
  return static_cast<int>(std::floor((height_m - c.low_m) / kBin_m));
}

/** Of the cells of a rectangle. */
std::vector<Column> columns_of(Site& site, const CellRect& cells, int floor, Which which)
{
  std::vector<Column> columns;
  const auto add = [&](std::size_t i, const CellRecord& c)
  {
    const bool stands = c.elevation_m > c.ground_m + kLowest_m;
    if (!stands && (which == Which::Standing || !is_known(c))) return;
    const auto width = static_cast<std::size_t>(cells.width_cells);
    const auto middle_m = [&](std::int64_t first, std::size_t cell)
    {
      return (static_cast<double>(first + static_cast<std::int64_t>(cell)) + 0.5) *
             site.resolution_m;
    };
    Column column;
    column.at = i;
    column.x_m = middle_m(cells.min_cell_x, i % width);
    column.y_m = middle_m(cells.min_cell_y, i / width);
    column.low_m = c.ground_m + kLowest_m;
    if (stands) column.top_bin = std::min(bin_of(c.elevation_m, column), kBins - 1);
    columns.push_back(column);
  };
  for_each_kept_cell(site.tiles, cells, floor, add);
  return columns;
}

/** Counts what a scan tells of a cell. */
void count(const SeenRays& scan, float resolution_m, bool is_recent, Column& c)
{
  std::uint32_t hit = 0, passed = 0;
  scan.for_each_over(
      c.x_m, c.y_m, c.low_m, c.low_m + kBins * kBin_m,
      [&](float height_m, float behind_m)
      {
        if (std::abs(behind_m) <= kHit_cells * resolution_m)
          hit |= bit(bin_of(height_m, c));
        else if (behind_m > kPassed_cells * resolution_m)
          passed |= bit(bin_of(height_m, c));
      });
  passed &= ~hit;
  if (hit != 0)
  {
    c.recent.scans += is_recent;
    c.recent.times += is_recent && !(scan.stamp_s() - c.last_hit_s < kVisit_s);
    if (std::isnan(c.first_hit_s)) c.first_hit_s = scan.stamp_s();
    c.last_hit_s = scan.stamp_s();
  }
  auto& passes = std::isnan(c.first_hit_s) ? c.before : c.later;
  for (int bin = 0; bin < kBins; ++bin)
  {
    const auto b = static_cast<std::size_t>(bin);
    c.hits[b] = static_cast<std::uint16_t>(c.hits[b] + (hit >> bin & 1));
    passes[b] = static_cast<std::uint16_t>(passes[b] + (passed >> bin & 1));
  }
}

struct Sums
{
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
  /** Whether rays passed there far more often than it was hit. */
  bool moved() const
  {
    const bool came_to_stay = hit_s > kStays_s * cells;
    return hits > 0 && later + (came_to_stay ? 0 : before) >= kPassesPerHit * hits;
  }
};

/** Those of the bins in which a cell was hit. Its top was hit at least once. */
Sums sums_of(const Column& c)
{
  Sums sums;
  sums.hits = c.top_bin == kNoBin ? 0 : 1;
  if (!std::isnan(c.first_hit_s)) sums.cells = 1, sums.hit_s = c.last_hit_s - c.first_hit_s;
  for (int bin = 0; bin < kBins; ++bin)
  {
    const auto b = static_cast<std::size_t>(bin);
    if (c.hits[b] == 0 && bin != c.top_bin) continue;
    sums.hits += c.hits[b];
    sums.before += c.before[b];
    sums.later += c.later[b];
  }
  return sums;
}

/** Whether what stood in a square around a cell has moved. */
bool has_moved(const std::vector<Sums>& sums, int side, std::size_t at, int radius)
{
  const int x = static_cast<int>(at) % side, y = static_cast<int>(at) / side;
  Sums all;
  for (int row = std::max(y - radius, 0); row <= std::min(y + radius, side - 1); ++row)
    for (int column = std::max(x - radius, 0); column <= std::min(x + radius, side - 1); ++column)
      all.add(sums[static_cast<std::size_t>(row * side + column)]);
  return all.moved();
}

void clear(SiteCell& s)
{
  const bool measured = is_measured(s);
  s.cell.elevation_m = measured ? s.cell.ground_m : NAN;
  s.cell.elevation_variance_m2 = measured ? s.cell.ground_variance_m2 : NAN;
}

/** The columns of a tile where something has moved; their places are those in the tile. Scans are
 * recent after a time. */
std::vector<Column> moved_of(
    Site& site, const TileKey& key, const Scans& scans, Which which, double recent_s)
{
  const int radius = static_cast<int>(std::lround(kAround_m / site.resolution_m)) / 2;
  const int side = kTileCells + 2 * radius;
  const CellRect cells{
      std::int64_t{key.x} * kTileCells - radius, std::int64_t{key.y} * kTileCells - radius, side,
      side};
  std::vector<Column> columns = columns_of(site, cells, key.floor, which), moved;
  for (const SeenRays* scan : scans)
    for (Column& c : columns)
      count(*scan, static_cast<float>(site.resolution_m), scan->stamp_s() > recent_s, c);
  std::vector<Sums> sums(cells.size());
  for (const Column& c : columns) sums[c.at] = sums_of(c);
  for (Column& c : columns)
  {
    const int x = static_cast<int>(c.at) % side - radius,
              y = static_cast<int>(c.at) / side - radius;
    const bool inside = x >= 0 && x < kTileCells && y >= 0 && y < kTileCells;
    if (!inside || sums[c.at].hits == 0 || !has_moved(sums, side, c.at, radius)) continue;
    c.at = static_cast<std::size_t>(y * kTileCells + x);
    moved.push_back(c);
  }
  return moved;
}

}  // namespace

void clear_traffic(Site& site, const Parameters& parameters, const TileKey& key, const Scans& scans)
{
  std::vector<int> moved;
  for (const Column& c : moved_of(site, key, scans, Which::Standing, 0))
    moved.push_back(static_cast<int>(c.at));
  if (moved.empty()) return;
  Tile& tile = site.tiles.at(key);
  for (const int at : moved) clear(tile.cells[static_cast<std::size_t>(at)]);
  judge_anew(site, parameters, key, moved);
}

void note_traffic(Site& site, const TileKey& key, const Scans& scans, Traffic& traffic)
{
  if (scans.empty()) return;
  const auto noted = traffic.find(key);
  const double noted_s = noted == traffic.end() ? -HUGE_VAL : noted->second.until_s;
  for (const Column& c : moved_of(site, key, scans, Which::All, noted_s))
  {
    if (c.recent.scans == 0) continue;
    TrafficCell& cell = traffic[key].cells[static_cast<int>(c.at)];
    cell.times += c.recent.times;
    cell.scans += c.recent.scans;
  }
  traffic[key].until_s = scans.back()->stamp_s();
}

}  // namespace talus::site
