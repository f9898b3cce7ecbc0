#pragma once
#include "kernels/cell.h"

namespace talus::kernels
{
// Stage 5 (III-B.4): which cells are inferred (again) from the updated map. Those are the unknown,
// the guesses, and measured "ground" that turns out to be an object whose ground was never seen.
//
// A measured ground is an object if it is both narrow and steep: it stands above the morphological
// opening of the measured ground (nothing as wide as object_size_m fits below its top: a wall, a
// rock, a branch; but not the edge of a platform or a kerb), and above a cone of the steepest
// drivable slope over ground close by (so that a rounded ridge is no object). Both work on pairs of
// cells, and in passes along rows and columns.

/** Cells of the map pooled two by two, by the parity of their place in the map, so that rolling
 * does not change the pairs. */
struct SupportGrid
{
  int side;  //!< pooled cells along each side
  float* lowest_m;  //!< lowest measured ground, infinity: none
  float* column_m;  //!< highest top of something upright, -infinity: none
  float* eroded_m;  //!< lowest ground of the neighbourhood
  float* cone_m;  //!< lowest ground of the neighbourhood, raised with distance
};

TALUS_HD int support_side(const Config& k) { return k.cells / 2 + 1; }

struct PoolSupport
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  SupportGrid grid;

  TALUS_HD void operator()(int px, int py) const
  {
    const int n = config->cells;
    float lowest = kInfinity, column = -kInfinity;
    const int x0 = 2 * px - frame->odd_x, y0 = 2 * py - frame->odd_y;
    for (int y = max_of(y0, 0); y < min_of(y0 + 2, n); y++)
      for (int x = max_of(x0, 0); x < min_of(x0 + 2, n); x++)
      {
        const int i = storage_index(*frame, n, x, y);
        if (store.state[i] != kMeasured) continue;
        const float ground = store.ground_m[i], top = store.elevation_m[i];
        lowest = min_of(lowest, ground);
        if (top - ground > 0.5f * config->clearance_m) column = max_of(column, top);
      }
    grid.lowest_m[py * grid.side + px] = lowest;
    grid.column_m[py * grid.side + px] = column;
  }
};

/** Rise of the steepest drivable slope between neighbours of the pooled grid. */
TALUS_HD float pooled_rise(const Config& k) { return 2.0f * k.support_slope * k.resolution_m; }

/** Lowest ground along a row of the pooled grid, plain and raised with distance. */
struct LowestGround
{
  float plain_m, cone_m;
};

/** Erosion: along rows first, then across them. */
struct ErodeSupport
{
  using Row = LowestGround;
  const Config* config;
  SupportGrid grid;

  TALUS_HD LowestGround row(int px, int py) const
  {
    const float rise = pooled_rise(*config);
    const float* ground = grid.lowest_m + py * grid.side;
    LowestGround lowest{kInfinity, kInfinity};
    const int last = min_of(px + config->object_radius, grid.side - 1);
    for (int x = max_of(px - config->object_radius, 0); x <= last; x++)
    {
      lowest.plain_m = min_of(lowest.plain_m, ground[x]);
      lowest.cone_m = min_of(lowest.cone_m, ground[x] + rise * static_cast<float>(abs_of(x - px)));
    }
    return lowest;
  }

  template <class Rows>
  TALUS_HD void operator()(int px, int py, const Rows& rows) const
  {
    const float rise = pooled_rise(*config);
    LowestGround lowest{kInfinity, kInfinity};
    const int last = min_of(py + config->object_radius, grid.side - 1);
    for (int y = max_of(py - config->object_radius, 0); y <= last; y++)
    {
      const LowestGround& row = rows(y);
      lowest.plain_m = min_of(lowest.plain_m, row.plain_m);
      lowest.cone_m = min_of(lowest.cone_m, row.cone_m + rise * static_cast<float>(abs_of(y - py)));
    }
    grid.eroded_m[py * grid.side + px] = lowest.plain_m;
    grid.cone_m[py * grid.side + px] = lowest.cone_m;
  }
};

/** Dilation of what was eroded, rows first; across them only where it matters, and the decision
 * for the cells of the window that were pooled. */
struct ChooseRoles
{
  using Row = float;
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  SupportGrid grid;
  const float* top_hit_m;  //!< of this frame, by storage index
  std::uint8_t* role;  //!< by storage index

  /** Highest eroded ground along a row; places without any ground do not count. */
  TALUS_HD float row(int px, int py) const
  {
    float highest = -kInfinity;
    const int last = min_of(px + config->object_radius, grid.side - 1);
    for (int x = max_of(px - config->object_radius, 0); x <= last; x++)
    {
      const float v = grid.eroded_m[py * grid.side + x];
      if (v < kInfinity) highest = max_of(highest, v);
    }
    return highest;
  }

  template <class Rows>
  TALUS_HD void operator()(int px, int py, const Rows& rows) const
  {
    const int n = config->cells;
    const int x0 = 2 * px - frame->odd_x, y0 = 2 * py - frame->odd_y;
    for (int y = max_of(y0, 0); y < min_of(y0 + 2, n); y++)
      for (int x = max_of(x0, 0); x < min_of(x0 + 2, n); x++)
      {
        const int i = storage_index(*frame, n, x, y);
        const bool measured = store.state[i] == kMeasured;
        role[i] = measured ? role_of_measured(px, py, store.ground_m[i], rows) : kInfer;
        if (!measured) join_column(i, px, py);
      }
  }

 private:
  /** What was hit far above guessed ground hangs there, unless it is joined to something upright: a
   * wall of which this cell was hit high up only. */
  TALUS_HD void join_column(int i, int px, int py) const
  {
    const float top = top_hit_m[i];
    if (is_known(store.elevation_m[i]) || !(top > store.ground_m[i] + config->clearance_m)) return;
    if (!between_columns(px, py, top - config->clearance_m)) return;
    store.elevation_m[i] = top;
    store.elevation_var_m2[i] = config->min_variance_m2;
  }

  template <class Rows>
  TALUS_HD Role role_of_measured(int px, int py, float ground_m, const Rows& rows) const
  {
    const float tolerance = 0.5f * config->step_threshold_m;
    if (ground_m <= grid.cone_m[py * grid.side + px] + tolerance) return kKeep;
    float opened = -kInfinity;
    const int last = min_of(py + config->object_radius, grid.side - 1);
    for (int y = max_of(py - config->object_radius, 0); y <= last; y++)
      opened = max_of(opened, rows(y));
    if (ground_m <= opened + tolerance) return kKeep;
    return column_beside(px, py) + config->clearance_m >= ground_m ? kObjectOnColumn : kObject;
  }

  /** Whether something upright stands at least so high on two opposite sides of the pooled cell. */
  TALUS_HD bool between_columns(int px, int py, float height_m) const
  {
    if (px == 0 || py == 0 || px == grid.side - 1 || py == grid.side - 1) return false;
    const float* at = grid.column_m + py * grid.side + px;
    const int steps[] = {1, grid.side, grid.side + 1, grid.side - 1};
    for (const int step : steps)
      if (at[-step] >= height_m && at[step] >= height_m) return true;
    return false;
  }

  /** Highest top of something upright in the pooled cell or next to it. */
  TALUS_HD float column_beside(int px, int py) const
  {
    float column = -kInfinity;
    for (int y = max_of(py - 1, 0); y <= min_of(py + 1, grid.side - 1); y++)
      for (int x = max_of(px - 1, 0); x <= min_of(px + 1, grid.side - 1); x++)
        column = max_of(column, grid.column_m[y * grid.side + x]);
    return column;
  }
};

}  // namespace talus::kernels
