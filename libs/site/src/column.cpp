#include "surroundings.h"

#include "kept_cell.h"
#include "strips.h"

#include <algorithm>

namespace talus::site
{
namespace
{
/// @name A ray hits a cell, or has passed it, if it ends so near to it, or so far behind it
/// @{
constexpr float kHit_cells = 1, kPassed_cells = 3;
/// @}
constexpr double kVisit_s = 3;  //!< what is hit after such a pause is another visit

std::uint32_t bit(int bin) { return bin >= 0 && bin < Column::kBins ? 1U << bin : 0; }
int bin_of(float height_m, const Column& c)
{
  return kernels::floor_to_int((height_m - c.low_m) / Column::kBin_m);
}

std::vector<Column> columns_of(Site& site, const CellRect& cells, int floor, Which which)
{
  std::vector<Column> columns;
  const auto add = [&](std::size_t i, const CellRecord& c)
  {
    const bool stands = c.elevation_m > c.ground_m + Column::kLowest_m;
    if (!stands && (which == Which::Standing || !is_known(c))) return;
    const auto width = static_cast<std::size_t>(cells.width_cells);
    const auto middle_m = [&](std::int64_t first, std::size_t cell)
    { return middle_of_cell_m(first + static_cast<std::int64_t>(cell), site.resolution_m); };
    Column column;
    column.at = i;
    column.x_m = middle_m(cells.min_cell_x, i % width);
    column.y_m = middle_m(cells.min_cell_y, i / width);
    column.low_m = c.ground_m + Column::kLowest_m;
    if (stands) column.top_bin = std::min(bin_of(c.elevation_m, column), Column::kBins - 1);
    columns.push_back(column);
  };
  for_each_kept_cell(site.tiles, cells, floor, add);
  return columns;
}

void count(std::uint32_t bins, std::array<std::uint16_t, Column::kBins>& counts)
{
  for (; bins != 0; bins &= bins - 1) ++counts[static_cast<std::size_t>(__builtin_ctz(bins))];
}

/** Counts what a scan saw of a cell. */
void count(const SeenRays& scan, float resolution_m, bool is_recent, Column& c)
{
  std::uint32_t hit = 0, passed = 0;  // bins above the cell
  scan.for_each_over(
      c.x_m, c.y_m, c.low_m, c.low_m + Column::kBins * Column::kBin_m,
      [&](float height_m, float behind_m)
      {
        if (std::abs(behind_m) <= kHit_cells * resolution_m)
          hit |= bit(bin_of(height_m, c));
        else if (behind_m > kPassed_cells * resolution_m)
          passed |= bit(bin_of(height_m, c));
      });
  passed &= ~hit;
  if ((hit | passed) == 0) return;
  if (hit != 0)
  {
    c.recent.scans += is_recent;
    c.recent.times += is_recent && !(scan.stamp_s() - c.last_hit_s < kVisit_s);
    if (std::isnan(c.first_hit_s)) c.first_hit_s = scan.stamp_s();
    c.last_hit_s = scan.stamp_s();
    c.when.set(scan.number() % c.when.size());
  }
  count(hit, c.hits);
  count(passed, std::isnan(c.first_hit_s) ? c.before : c.later);
}
}  // namespace

std::vector<Column> count_columns(
    Site& site, const CellRect& cells, int floor, Which which, const Scans& scans, double recent_s)
{
  std::vector<Column> columns = columns_of(site, cells, floor, which);
  const auto resolution_m = static_cast<float>(site.resolution_m);
  for (const SeenRays* scan : scans)
    for (Column& c : columns) count(*scan, resolution_m, scan->stamp_s() > recent_s, c);
  return columns;
}

}  // namespace talus::site
