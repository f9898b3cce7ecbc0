#pragma once
#include "kernels/rays.h"

namespace talus::kernels
{
/** Stage 9 (III-C.5) speaks of one-sided fills with dense data around them: at least a quarter of
 * the cells in the neighbourhood of stage 8 are measured. */
TALUS_HD bool dense_around(int measured, int radius_cells)
{
  const int side = 2 * radius_cells + 1;
  return kDenseOneIn * measured >= side * side;
}

/** From the sensor along its line to the cell at (dx, dy) != 0 [m]. */
TALUS_HD float distance_along_line(int dx, int dy, const Config& k)
{
  const int rings = line_rings(k), ring = max_of(abs_of(dx), abs_of(dy));
  const float step_m = line_stretch(line_through(dx, dy, ring, rings), rings) * k.resolution_m;
  return static_cast<float>(ring) * step_m;
}

/** Height difference of the ground on both sides of a gap, less what a slope half as steep as is
 * allowed explains: a floor that is seen far behind the crest of a ramp does not make it a cliff.
 */
TALUS_HD float drop_across(float inner_m, float outer_m, float gap_m, const Config& k)
{
  return max_of(abs_of(inner_m - outer_m) - kExplainedSlope * k.max_slope * gap_m, 0.0f);
}

/** Eq. 14 from the height difference h_s of the ground found on both sides, searched farther than a
 * fill does, and the distance d_s to the robot. NaN (unknown) where one side has none. */
TALUS_HD float sparsity(float h_s, float robot_m, const Config& k)
{
  if (!is_known(h_s)) return kNan;
  const float ratio = h_s * k.inverse_step_threshold;
  if (h_s < k.step_threshold_m) return clamp01(1.0f - ratio);
  return clamp01(1.0f - ratio * k.sparsity_distance_m / robot_m);
}

}  // namespace talus::kernels
