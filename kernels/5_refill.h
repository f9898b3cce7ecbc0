#pragma once
#include "kernels/cell.h"

namespace talus::kernels
{
// Stage 5 (III-B.4): which cells are inferred (again) from the updated map. Those are the unknown,
// the guesses, and measured "ground" that turns out to be an object whose ground was never seen:
// its lowest point stands more than a step above a cone of the steepest drivable slope over
// measured ground close by. The cone of the city-block distance is separable: one pass along rows,
// one along columns.

/** How far away ground is looked for under a suspected object, in cells. */
constexpr int kSupportRadius = 3;

/** Low and high of the surroundings of one cell along its row; rows of `cells` entries, window
 * order. */
struct SupportRows
{
  float* lowest_cone_m;  //!< lowest measured ground, raised with distance
  float* column_top_m;  //!< highest top of something that stands upright beside
};

struct GatherSupportRow
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  SupportRows rows;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int n = config->cells;
    const float rise = config->support_slope * config->resolution_m;
    float cone = kInfinity, column = -kInfinity;
    for (int x = max_of(ix - kSupportRadius, 0); x <= min_of(ix + kSupportRadius, n - 1); x++)
    {
      const int i = storage_index(*frame, n, x, iy);
      if (store.state[i] != kMeasured) continue;
      const float ground = store.ground_m[i], top = store.elevation_m[i];
      cone = min_of(cone, ground + rise * static_cast<float>(abs_of(x - ix)));
      if (top - ground > 0.5f * config->clearance_m) column = max_of(column, top);
    }
    rows.lowest_cone_m[iy * n + ix] = cone;
    rows.column_top_m[iy * n + ix] = column;
  }
};

struct ChooseRole
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  SupportRows rows;
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
    const int n = config->cells;
    const float rise = config->support_slope * config->resolution_m;
    float cone = kInfinity, column = -kInfinity;
    for (int y = max_of(iy - kSupportRadius, 0); y <= min_of(iy + kSupportRadius, n - 1); y++)
    {
      cone =
          min_of(cone, rows.lowest_cone_m[y * n + ix] + rise * static_cast<float>(abs_of(y - iy)));
      column = max_of(column, rows.column_top_m[y * n + ix]);
    }
    if (ground_m <= cone + config->step_threshold_m) return kKeep;
    return column + config->clearance_m >= ground_m ? kObjectOnColumn : kObject;
  }
};

}  // namespace talus::kernels
