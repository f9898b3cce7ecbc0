#pragma once
#include "kernels/6_fill.h"
#include "kernels/rule_constants.h"

namespace talus::kernels
{
/** A range of unmeasured ground along a line from the sensor. */
struct Gap
{
  float length_m = 0;
  float near_m = kNan, far_m = kNan;  //!< samples before and behind it; NaN: too far
  float behind_m = kNan, behind_length_m = 0;  //!< the next one behind it, and how far that is
};

struct Fall
{
  float m = kNan;  //!< h_s of eq. 14; NaN: the ground on one side is too far
  std::int32_t slopes = 0;  //!< it falls by a step over more than a ditch is wide, as a slope does
};

/** h_s of eq. 14: how much lower than the ground before it the ground in a gap may lie. A drivable
 * slope explains a part of the fall. If the far side begins lower and rises more steeply than a
 * robot can drive, behind it or within its own cell, it is the far wall of a ditch, of which the
 * near edge hides the lower part: the ditch may be twice as deep. In a gap that is wider than a
 * ditch it must be lower by a step, too, and lead back up by half of that on a shorter path. */
TALUS_HD Fall fall_in(const Gap& g, const Config& k)
{
  const float near_m = select(is_stood(g.near_m), kNan, g.near_m);
  const float fall_m = near_m - g.far_m, rise_m = g.behind_m - g.far_m;
  const float explained_m =
      min_of(kExplainedSlope * k.max_slope * g.length_m, kExplained_steps * k.step_threshold_m);
  const bool wide = g.length_m >= kWidestDitch_m;
  const bool back_up =
      (fall_m > k.step_threshold_m) & (rise_m >= 0.5f * fall_m) & (g.behind_length_m <= g.length_m);
  const bool steep = is_steep(rise_m, g.behind_length_m, k) | is_face(g.far_m);
  const bool wall = steep & select(wide, back_up, true);
  const float ditch_m = kDitchDepthFactor * (fall_m - kGentle * g.length_m);
  const float below_m = max_of(max_of(fall_m - explained_m, select(wall, ditch_m, 0.0f)), 0.0f);
  return {below_m, select((below_m == 0.0f) & wide & (fall_m > k.step_threshold_m), 1, 0)};
}

/** Eq. 14 from the height difference h_s of the ground on both sides, searched farther than for a
 * fill, and the distance d_s to the robot; NaN where one side has none. */
TALUS_HD float sparsity(float h_s, float robot_m, const Config& k)
{
  const float ratio = h_s * k.inverse_step_threshold;
  const float weight = select(h_s < k.step_threshold_m, 1.0f, k.sparsity_distance_m / robot_m);
  return select(is_known(h_s), clamp01(1.0f - ratio * weight), kNan);
}

/** Adds to the FillMark of an inferred cell near the robot what follows from the gap in which it
 * lies. Returns h_s of eq. 14; NaN where that does not apply. */
TALUS_HD float estimate_fall(const Gap& gap, float robot_m, std::int32_t& marks, const Config& k)
{
  const bool applies = (robot_m <= k.sparsity_range_m) & ((marks & kInferred) != 0);
  const Fall fall = fall_in(gap, k);
  const std::int32_t found = select(sparsity(fall.m, robot_m, k) < kSparse, kDrops, 0) |
                             select(fall.slopes != 0, kSlopes, 0);
  marks |= select(applies, found, 0);
  return select(applies, fall.m, kNan);
}

}  // namespace talus::kernels
