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
  // after the pass along rows
  float* row_lowest_m;
  float* row_cone_m;
  // after the pass along columns
  float* eroded_m;  //!< lowest ground of the neighbourhood
  float* cone_m;  //!< lowest ground of the neighbourhood, raised with distance
  float* row_opened_m;  //!< highest eroded ground along the row
};

TALUS_HD int support_side(const Config& k) { return k.cells / 2 + 1; }

/** Place of a cell of the window in the pooled grid. */
TALUS_HD int pooled_index(const FrameContext& f, const SupportGrid& grid, int ix, int iy)
{
  return ((iy + f.odd_y) >> 1) * grid.side + ((ix + f.odd_x) >> 1);
}

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

struct ErodeSupportRow
{
  const Config* config;
  SupportGrid grid;

  TALUS_HD void operator()(int px, int py) const
  {
    const float rise = pooled_rise(*config);
    const float* row = grid.lowest_m + py * grid.side;
    float lowest = kInfinity, cone = kInfinity;
    const int last = min_of(px + config->object_radius, grid.side - 1);
    for (int x = max_of(px - config->object_radius, 0); x <= last; x++)
    {
      lowest = min_of(lowest, row[x]);
      cone = min_of(cone, row[x] + rise * static_cast<float>(abs_of(x - px)));
    }
    grid.row_lowest_m[py * grid.side + px] = lowest;
    grid.row_cone_m[py * grid.side + px] = cone;
  }
};

struct ErodeSupportColumn
{
  const Config* config;
  SupportGrid grid;

  TALUS_HD void operator()(int px, int py) const
  {
    const float rise = pooled_rise(*config);
    float lowest = kInfinity, cone = kInfinity;
    const int last = min_of(py + config->object_radius, grid.side - 1);
    for (int y = max_of(py - config->object_radius, 0); y <= last; y++)
    {
      const int i = y * grid.side + px;
      lowest = min_of(lowest, grid.row_lowest_m[i]);
      cone = min_of(cone, grid.row_cone_m[i] + rise * static_cast<float>(abs_of(y - py)));
    }
    grid.eroded_m[py * grid.side + px] = lowest;
    grid.cone_m[py * grid.side + px] = cone;
  }
};

/** Highest of a stretch of the eroded ground; places without any ground do not count. */
TALUS_HD float highest_known(const float* values, int first, int last, int stride)
{
  float highest = -kInfinity;
  for (int i = first; i <= last; i++)
  {
    const float v = values[i * stride];
    if (v < kInfinity) highest = max_of(highest, v);
  }
  return highest;
}

struct OpenSupportRow
{
  const Config* config;
  SupportGrid grid;

  TALUS_HD void operator()(int px, int py) const
  {
    const int r = config->object_radius;
    grid.row_opened_m[py * grid.side + px] = highest_known(
        grid.eroded_m + py * grid.side, max_of(px - r, 0), min_of(px + r, grid.side - 1), 1);
  }
};

/** The last pass, along columns, and the decision for each cell of the window. */
struct ChooseRole
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  SupportGrid grid;
  std::uint8_t* role;  //!< by storage index

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int i = storage_index(*frame, config->cells, ix, iy);
    const std::uint8_t state = store.state[i];
    if (state == kMeasured)
      role[i] = role_of_measured(ix, iy, store.ground_m[i]);
    else
      role[i] = state == kFilledTwoSided ? kKeep : kInfer;
  }

 private:
  TALUS_HD Role role_of_measured(int ix, int iy, float ground_m) const
  {
    const int p = pooled_index(*frame, grid, ix, iy);
    const float tolerance = 0.5f * config->step_threshold_m;
    if (ground_m <= grid.cone_m[p] + tolerance) return kKeep;
    const int px = p % grid.side, py = p / grid.side, r = config->object_radius;
    const float opened = highest_known(
        grid.row_opened_m + px, max_of(py - r, 0), min_of(py + r, grid.side - 1), grid.side);
    if (ground_m <= opened + tolerance) return kKeep;
    return column_beside(px, py) + config->clearance_m >= ground_m ? kObjectOnColumn : kObject;
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
