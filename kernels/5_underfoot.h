#pragma once
#include "kernels/atomics.h"
#include "kernels/cell.h"

namespace talus::kernels
{
/** What stands where the robot stands is nothing that stops it: grass, or what has left. There the
 * ground is that under its base, and hits up to the height that it drove through are nothing new.
 * The robot stands below a disc around its base and below the boxes of its body. */
template <class Atomics>
struct StandOnCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  Datum* datum;
  const Body* body;

  /** Whether it applies to no cell of a row. */
  TALUS_HD bool leaves_out(int iy) const
  {
    const float reach_m = max_of(kFootprint_m, body->reach_m);
    return frame->has_base == 0 || abs_of(from_base(iy, frame->base_y_m)) > reach_m;
  }
  TALUS_HD bool applies(int ix, int iy, int storage_i) const
  {
    const float x_m = from_base(ix, frame->base_x_m), y_m = from_base(iy, frame->base_y_m);
    const float reach_m = max_of(kFootprint_m, body->reach_m);
    const bool near = x_m * x_m + y_m * y_m <= reach_m * reach_m;
    const float above_m = kUnderFoot_steps * config->step_threshold_m;
    const float floor_m = plane_m(x_m, y_m), through_m = frame->drove_through_m;
    const float ground_m = store.ground_m[storage_i];
    const bool high = (ground_m > floor_m + above_m) |
                      (store.elevation_m[storage_i] > floor_m + above_m) |
                      ((through_m > above_m) & !is_driven(store.footing[storage_i]));
    return (frame->has_base != 0) & near & high;
  }
  TALUS_HD void operator()(int ix, int iy, int storage_i) const
  {
    const float x_m = from_base(ix, frame->base_x_m), y_m = from_base(iy, frame->base_y_m);
    if (!is_under(x_m, y_m)) return;
    const float floor_m = plane_m(x_m, y_m);
    Cell c = store.load(storage_i);
    const float above_m = kUnderFoot_steps * config->step_threshold_m;
    // A guess is nothing that the robot drove through: it was wrong.
    const float top_m = is_known(c.elevation_m) ? max_of(c.elevation_m, c.ground_m) : floor_m;
    const float stood_m = max_of(min_of(top_m - floor_m, config->clearance_m), 0.0f);
    Atomics::max(&datum->drove_through, floor_to_int(stood_m / kDrivenUnit_m));
    const bool sunk = abs_of(c.ground_m - floor_m) <= above_m;
    c.ground_m = select(sunk, c.ground_m, floor_m);
    c.ground_var_m2 = select(sunk, c.ground_var_m2, kUnderFoot_var_m2);
    if (!is_known(c.elevation_m) && frame->drove_through_m <= above_m)
    {
      store.store(storage_i, c);
      return;
    }
    c.elevation_m = c.ground_m;
    c.elevation_var_m2 = c.ground_var_m2;
    c.state = kMeasured;
    c.persistence = c.extent = 0;
    c.ray_evidence = kPassedLow;
    c.footing = (c.footing & kPassedNear) | footing_driven_through(
                                                max_of(stood_m, frame->drove_through_m) +
                                                kStandsUp_steps * config->step_threshold_m);
    store.store(storage_i, c);
  }

 private:
  TALUS_HD bool is_under(float x_m, float y_m) const
  {
    if (x_m * x_m + y_m * y_m <= kFootprint_m * kFootprint_m) return true;
    // From the window's axes to the sensor's and to the base's.
    const float* const s = frame->poses[0].m;
    const float* const b = frame->T_base_sensor;
    const float z_m = frame->base_slope_x * x_m + frame->base_slope_y * y_m;
    const float in_sensor[3] = {
        s[0] * x_m + s[4] * y_m + s[8] * z_m, s[1] * x_m + s[5] * y_m + s[9] * z_m,
        s[2] * x_m + s[6] * y_m + s[10] * z_m};
    const float ahead_m = b[0] * in_sensor[0] + b[1] * in_sensor[1] + b[2] * in_sensor[2];
    const float left_m = b[4] * in_sensor[0] + b[5] * in_sensor[1] + b[6] * in_sensor[2];
    for (int box = 0; box < body->boxes; box++)
      if (ahead_m >= body->min_m[box][0] && ahead_m <= body->max_m[box][0] &&
          left_m >= body->min_m[box][1] && left_m <= body->max_m[box][1])
        return true;
    return false;
  }
  TALUS_HD float from_base(int cell, float base_m) const
  {
    return (static_cast<float>(cell) + 0.5f) * config->resolution_m - base_m;
  }
  /** The ground under the base, above the map's datum. */
  TALUS_HD float plane_m(float x_m, float y_m) const
  {
    return frame->base_z_m - frame->offset_m + frame->base_slope_x * x_m +
           frame->base_slope_y * y_m;
  }
};

}  // namespace talus::kernels
