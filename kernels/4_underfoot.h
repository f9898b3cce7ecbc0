#pragma once
#include "kernels/atomics.h"
#include "kernels/map.h"

namespace talus::kernels
{
/** The middle of a cell, from another position in the window. */
struct Offset
{
  float x_m, y_m;

  TALUS_HD bool is_within(float radius_m) const
  {
    return x_m * x_m + y_m * y_m <= radius_m * radius_m;
  }
};
TALUS_HD Offset offset_of(const Config& k, int ix, int iy, float from_x_m, float from_y_m)
{
  return {
      (static_cast<float>(ix) + 0.5f) * k.resolution_m - from_x_m,
      (static_cast<float>(iy) + 0.5f) * k.resolution_m - from_y_m};
}
TALUS_HD Offset offset_from_base(const Config& k, const FrameContext& f, int ix, int iy)
{
  return offset_of(k, ix, iy, f.base_x_m, f.base_y_m);
}
/** Height above the datum of the plane on which the base stands, at an offset from the base. */
TALUS_HD float plane_of_base_m(const FrameContext& f, const Offset& at)
{
  return f.base_z_m - f.offset_m + f.base_slope_x * at.x_m + f.base_slope_y * at.y_m;
}
/** Gives presumed ground to a cell that was not measured. An object on it stays. */
TALUS_HD void presume_ground(Cell& c, float ground_m)
{
  c.ground_m = ground_m;
  c.ground_var_m2 = kUnderFoot_var_m2;
  c.state = kPresumed;
}

/** What the robot stands on does not block it: grass, or an object that is gone. The cells below a
 * disc around the base get the ground of the base. Later hits up to the height that the robot drove
 * through do not count as new. Boxes of its body do not count: mirrors pass above objects. */
template <class Atomics>
struct StandOnCell
{
  const Map& m;

  TALUS_HD bool leaves_out(int iy) const
  {
    return m.frame->has_base == 0 ||
           abs_of(offset_from_base(m.k, *m.frame, 0, iy).y_m) > kFootprint_m;
  }
  TALUS_HD bool applies(int ix, int iy, int i) const
  {
    const Offset at = offset_from_base(m.k, *m.frame, ix, iy);
    const bool changes =
        drives_through(i, plane_of_base_m(*m.frame, at)) | !m.cell.is(kRobotWasThere, i);
    return on(kUnderRobot, m.k) & (m.frame->has_base != 0) & at.is_within(kFootprint_m) & changes;
  }
  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    const float floor_m = plane_of_base_m(*m.frame, offset_from_base(m.k, *m.frame, ix, iy));
    if (!drives_through(i, floor_m))
    {
      m.cell.flags[i] |= kRobotWasThere;
      return;
    }
    Cell c = m.cell.load(i);
    const float above_m = kUnderFoot_steps * m.k.step_threshold_m;
    // Over unmeasured ground without an object it drove through nothing: the guess was wrong.
    const float top_m = is_known(c.elevation_m) ? max_of(c.elevation_m, c.ground_m) : floor_m;
    const float stood_m = max_of(min_of(top_m - floor_m, m.k.clearance_m), 0.0f);
    Atomics::max(&m.datum->drove_through, floor_to_int(stood_m / kDrivenUnit_m));
    const bool sunk = abs_of(c.ground_m - floor_m) <= above_m;
    c.ground_m = select(sunk, c.ground_m, floor_m);
    c.ground_var_m2 = select(sunk, c.ground_var_m2, kUnderFoot_var_m2);
    if (!is_known(c.elevation_m) && m.frame->drove_through_m <= above_m)
    {
      if (c.state != kMeasured) presume_ground(c, floor_m), c.flags |= kPassedLow;
      c.flags |= kRobotWasThere;
      m.cell.store(i, c);
      return;
    }
    c.state = kMeasured;
    remove_object(c);
    c.recent_hits = 0;
    c.flags = kPassedLow | kRobotWasThere;
    c.driven_height = driven_units(
        max_of(stood_m, m.frame->drove_through_m) + kStandsUp_steps * m.k.step_threshold_m);
    m.cell.store(i, c);
  }

 private:
  TALUS_HD bool drives_through(int i, float floor_m) const
  {
    const float above_m = kUnderFoot_steps * m.k.step_threshold_m;
    const bool high =
        (m.cell.ground_m[i] > floor_m + above_m) | (m.cell.elevation_m[i] > floor_m + above_m) |
        ((m.frame->drove_through_m > above_m) & !was_driven_through(m.cell.driven_height[i]));
    const int state = m.cell.state[i];
    const bool guessed =
        (state != kMeasured) & (state != kPresumed) & !is_known(m.cell.elevation_m[i]);
    return high | guessed;
  }
};

}  // namespace talus::kernels
