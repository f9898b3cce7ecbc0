#pragma once
#include "kernels/5_underfoot.h"
#include "kernels/6_cleanup.h"

namespace talus::kernels
{
/** A robot that starts stands on ground that its map does not know: its scanner looks over it. What
 * was not measured around it is presumed to be the plane of its base, until it is measured, or rays
 * pass below it, see stage 6. In a frame that starts a map. */
struct PresumeStart
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  PassingRays passing;

  TALUS_HD bool applies_to_frame() const
  {
    return (frame->starts_map != 0) & (frame->has_base != 0);
  }
  TALUS_HD bool applies(int ix, int iy, int storage_i) const
  {
    const float x_m = from_base_m(*config, ix, frame->base_x_m);
    const float y_m = from_base_m(*config, iy, frame->base_y_m);
    const float radius_m = config->start_radius_m;
    const bool near = x_m * x_m + y_m * y_m <= radius_m * radius_m;
    const int state = store.state[storage_i];
    return near & (state != kMeasured) & (state != kPresumed);
  }
  TALUS_HD void operator()(int ix, int iy, int storage_i) const
  {
    const int window_i = iy * config->cells + ix;
    const float plane_m = plane_at(ix, iy);
    const float bound_m = select(
        passing.lowest_m[window_i] < kInfinity,
        passing.highest_m[window_i] + config->cleanup_margin_m, kInfinity);
    if (plane_m > bound_m || (config->start_automatic != 0 && !is_blind(ix, iy))) return;
    Cell c = store.load(storage_i);
    presume_ground(c, plane_m);
    store.store(storage_i, c);
  }

 private:
  TALUS_HD float plane_at(int ix, int iy) const
  {
    return plane_of_base_m(
        *frame, from_base_m(*config, ix, frame->base_x_m),
        from_base_m(*config, iy, frame->base_y_m));
  }
  /** Whether the scanner looks over the cell: nothing was hit before it, and where the lowest ray
   * above it would be below the plane, as far as the window goes, there is none. */
  TALUS_HD bool is_blind(int ix, int iy) const
  {
    const int n = config->cells, window_i = iy * n + ix;
    const float x_m = (static_cast<float>(ix) + 0.5f) * config->resolution_m - frame->sensor_x_m;
    const float y_m = (static_cast<float>(iy) + 0.5f) * config->resolution_m - frame->sensor_y_m;
    const float away_m = chebyshev(x_m, y_m);
    if (away_m < kUnderSensor_rings * config->resolution_m) return true;
    if (passing.in_open[window_i] == 0) return false;
    // Heights of rays and of the plane, by chebyshev distance; rays as add_ray() takes them.
    const float below_m = kStartUndercut_steps * config->step_threshold_m;
    const float here_m = plane_at(ix, iy);
    const float under_sensor_m = here_m - frame->base_slope_x * x_m - frame->base_slope_y * y_m;
    const float rise = (here_m - under_sensor_m) / away_m;
    const float slope = (passing.lowest_m[window_i] - frame->sensor_z_m) /
                        (away_m - 0.5f * config->resolution_m);
    const float meets_m = (frame->sensor_z_m - under_sensor_m + below_m) / (rise - slope);
    const bool meets = (slope < rise) & (meets_m < static_cast<float>(n) * config->resolution_m);
    const float share = select(meets, meets_m / away_m, 0.0f);
    const int x = floor_to_int((frame->sensor_x_m + x_m * share) * config->inverse_resolution);
    const int y = floor_to_int((frame->sensor_y_m + y_m * share) * config->inverse_resolution);
    if (!meets | (x < 0) | (y < 0) | (x >= n) | (y >= n)) return true;
    return !(passing.lowest_m[y * n + x] < plane_at(x, y) - 0.5f * below_m);
  }
};

}  // namespace talus::kernels
