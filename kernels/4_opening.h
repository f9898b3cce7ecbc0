#pragma once
#include "kernels/cell.h"
#include "kernels/coarse_grid.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"
#include "kernels/rule_switches.h"

namespace talus::kernels
{
// Stage 4 (III-B.4) decides which cells are inferred again from the updated map: unknown cells,
// guesses, and measured "ground" that is in fact an object above unseen ground. Measured ground is
// an object if it is both narrow and steep. Narrow: it lies above the morphological opening of the
// measured ground, since nothing as wide as object_size_m fits below its top. Steep: it lies above
// a cone of the steepest slope over ground close by, so that a ridge or a bank is no object. Both
// work on pairs of cells, along rows and then along columns. Bridges are the exception, see
// 4_classify.h.

struct CoarseCell
{
  float lowest_m = kInfinity, column_m = -kInfinity;
  std::int32_t presence = kEmpty;  //!< the highest Presence
};

struct PoolCells
{
  using Item = CoarseCell;
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  CoarseGrid grid;

  TALUS_HD CoarseCell item(int storage_i) const
  {
    const float ground = store.ground_m[storage_i], top = store.elevation_m[storage_i];
    const bool measured = store.state[storage_i] == kMeasured;
    const bool upright = measured & (top - ground > kUpright_steps * config->step_threshold_m);
    const bool stands = top > bare_up_to_m(ground, *config);
    const int bare = select(store.recent_hits[storage_i] > 0, kLeft, kEmpty);
    return {
        select(measured, ground, kInfinity), select(upright, top, -kInfinity),
        select(stands, kStands, bare)};
  }
  /** Joins two cells, or two such pairs. */
  TALUS_HD CoarseCell pool(const CoarseCell& a, const CoarseCell& b) const
  {
    return {
        min_of(a.lowest_m, b.lowest_m), max_of(a.column_m, b.column_m),
        max_of(a.presence, b.presence)};
  }
  TALUS_HD void put(int px, int py, const CoarseCell& pooled) const
  {
    grid.lowest_m[grid.at(px, py)] = pooled.lowest_m;
    grid.column_m[grid.at(px, py)] = pooled.column_m;
    grid.presence[grid.at(px, py)] = static_cast<float>(pooled.presence);
  }

  TALUS_HD void operator()(int px, int py) const
  {
    const int n = config->cells;
    const int x0 = grid.first_cell(px, frame->odd_x), y0 = grid.first_cell(py, frame->odd_y);
    const auto cell = [this, n](int x, int y)
    {
      const bool inside = (x >= 0) & (y >= 0) & (x < n) & (y < n);
      return inside ? item(storage_index(*frame, n, x, y)) : CoarseCell{};
    };
    const CoarseCell left = pool(cell(x0, y0), cell(x0, y0 + 1));
    put(px, py, pool(left, pool(cell(x0 + 1, y0), cell(x0 + 1, y0 + 1))));
  }
};

/** Rise of the steepest ground between neighbouring coarse cells: 45 degrees, or what the robot
 * climbs. */
TALUS_HD float pooled_rise(const Config& k)
{
  return 2.0f * max_of(k.max_slope, kSteepestBank) * k.resolution_m;
}

/** Lowest ground of a neighbourhood in the coarse grid, plain and raised with distance. */
struct LowestGround
{
  float plain_m = kInfinity, cone_m = kInfinity;
};

/** Erosion, along rows and then along columns. Only ground that is known, with nothing upright on
 * it or beside it, can be wide: neither a face and its edges nor the unknown behind it. */
struct ErodeGround
{
  using Row = LowestGround;
  using Window = LowestGround;
  static constexpr bool kHasPlain = false;
  const Config* config;
  CoarseGrid grid;

  TALUS_HD const float& neighbour(int px, int py) const { return grid.lowest_m[grid.at(px, py)]; }
  TALUS_HD void add(LowestGround& row, int px, int py, int d) const
  {
    const float ground = neighbour(px + d, py);
    add(row, {ground, ground}, d);
  }
  TALUS_HD void add(LowestGround& sum, const LowestGround& other, int d) const
  {
    const float rise = pooled_rise(*config) * static_cast<float>(abs_of(d));
    sum.plain_m = min_of(sum.plain_m, other.plain_m);
    sum.cone_m = min_of(sum.cone_m, other.cone_m + rise);
  }

  TALUS_HD void operator()(int px, int py, const LowestGround& lowest) const
  {
    erode(px, py, lowest, true);
  }
  /** Returns the result to executors that use it at once; stores only places of the caller's `own`.
   */
  TALUS_HD float erode(int px, int py, const LowestGround& lowest, bool own) const
  {
    const int coarse_i = grid.at(px, py);
    const float eroded_m = select(may_be_wide(px, py), lowest.plain_m, kInfinity);
    if (own) grid.cone_m[coarse_i] = lowest.cone_m, grid.eroded_m[coarse_i] = eroded_m;
    return eroded_m;
  }

 private:
  TALUS_HD bool may_be_wide(int px, int py) const
  {
    if (!on(kBareIsWide, *config)) return true;
    bool any = false;
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++)
      {
        const int y = min_of(max_of(py + dy, 0), grid.side - 1);
        const float column_m = grid.column_m[grid.at(px + dx, y)];
        any |= (column_m > -kInfinity) & (column_m < kInfinity);
      }
    return !any & (grid.lowest_m[grid.at(px, py)] < kInfinity);
  }
};

/** Highest eroded ground of a neighbourhood; places without any ground do not count. */
struct HighestGround
{
  float height_m = -kInfinity;
};

/** Dilation of the eroded ground: ground is what is not both narrow and steep. Near upright objects
 * the lowest hit is the ground only where bare ground goes on from there, if there is any in reach.
 * (In high grass there is none.) */
struct OpenGround
{
  using Row = HighestGround;
  using Window = HighestGround;
  static constexpr bool kHasPlain = false;
  const Config* config;
  CoarseGrid grid;

  TALUS_HD const float& neighbour(int px, int py) const { return grid.eroded_m[grid.at(px, py)]; }
  TALUS_HD void add(HighestGround& row, int px, int py, int d) const
  {
    add(row, neighbour(px + d, py));
  }
  TALUS_HD void add(HighestGround& row, float eroded_m) const
  {
    row.height_m = max_of(row.height_m, select(eroded_m < kInfinity, eroded_m, -kInfinity));
  }
  TALUS_HD void add(HighestGround& sum, const HighestGround& other, int) const
  {
    sum.height_m = max_of(sum.height_m, other.height_m);
  }

  TALUS_HD void operator()(int px, int py, const HighestGround& opened) const
  {
    const int coarse_i = grid.at(px, py);
    const float by_cone_m = grid.cone_m[coarse_i] + kAboveCone_steps * config->step_threshold_m;
    const float by_width_m = opened.height_m + kAboveOpening_steps * config->step_threshold_m;
    const bool told = (grid.eroded_m[coarse_i] == kInfinity) & (opened.height_m > -kInfinity);
    const float steep_m = select(told, -kInfinity, by_cone_m);
    grid.limit_m[coarse_i] = max_of(steep_m, by_width_m);
  }
};

}  // namespace talus::kernels
