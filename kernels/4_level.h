#pragma once
#include "kernels/2_points.h"

namespace talus::kernels
{
// Stage 4 takes the heights of points to the middle of their cell: on a slope a point lies as much
// higher or lower as it is away from there, and the rings of a scanner meet a cell at the same
// place again and again.

/** How the ground rises through a cell. */
struct GroundRise
{
  float x = 0, y = 0;  //!< [m per cell]
  float middle_m = kNan;  //!< about so high is it; NaN: not known

  /** Height in the middle of the cell of a point, as it was where that is no hit of the ground. */
  TALUS_HD float level(float height_m, const InCell& at) const
  {
    const bool near_ground = abs_of(height_m - middle_m) <= kNearGround_m;
    return select(near_ground, height_m - at.x * x - at.y * y, height_m);
  }
};

/** Finds it from the nearest measured cells on both sides along x and along y, as the last frame
 * left them. */
struct FindRise
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;

  /** Of the cell stored there. */
  TALUS_HD GroundRise operator()(int storage_i) const
  {
    const int n = config->cells, row = floor_div(storage_i, n, 1.0f / static_cast<float>(n));
    const int column = storage_i - row * n;
    const Along x = along({row * n, 1, column, frame->storage_x});
    const Along y = along({column, n, row, frame->storage_y});
    const bool has_x = is_known(x.middle_m), has_y = is_known(y.middle_m);
    const float both_m = 0.5f * (x.middle_m + y.middle_m);
    return {
        x.rise_m, y.rise_m, select(has_x & has_y, both_m, select(has_x, x.middle_m, y.middle_m))};
  }

 private:
  /** A row or column of storage, a place on it, and where the window begins. */
  struct Axis
  {
    int first, stride, place, begin;
  };
  struct Along
  {
    float rise_m = 0, middle_m = kNan;
  };
  struct Ground
  {
    float height_m = kNan;
    int cells_away = 0;
  };

  TALUS_HD Ground nearest(const Axis& axis, int direction, int most) const
  {
    const int n = config->cells;
    for (int d = 1; d <= most; d++)
    {
      const int at = axis.place + d * direction;
      const int storage_i =
          axis.first + (at + select(at < 0, n, 0) - select(at >= n, n, 0)) * axis.stride;
      if (store.state[storage_i] == kMeasured) return {store.ground_m[storage_i], d};
    }
    return {};
  }

  /** Nothing where a side is missing, or where that is steeper than a robot can drive. */
  TALUS_HD Along along(const Axis& axis) const
  {
    const int n = config->cells, before = axis.place - axis.begin;
    const int in_window = before + select(before < 0, n, 0);
    const Ground a = nearest(axis, -1, min_of(kBesidePoint_cells, in_window));
    const Ground b = nearest(axis, 1, min_of(kBesidePoint_cells, n - 1 - in_window));
    if (a.cells_away == 0 || b.cells_away == 0) return {};
    const float rise_m =
        (b.height_m - a.height_m) / static_cast<float>(a.cells_away + b.cells_away);
    if (abs_of(rise_m) > config->max_slope * config->resolution_m) return {};
    return {rise_m, 0.5f * (a.height_m + b.height_m)};
  }
};

}  // namespace talus::kernels
