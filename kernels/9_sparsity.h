#pragma once
#include "kernels/7_fill.h"

namespace talus::kernels
{
/** Stage 9 (III-C.5) speaks of one-sided fills with dense data around them: at least a quarter of
 * the cells in the neighbourhood of stage 8 are measured. */
TALUS_HD bool dense_around(int measured, int radius_cells)
{
  const int side = 2 * radius_cells + 1;
  return 4 * measured >= side * side;
}

/** Eq. 14 from the height difference h_s of the ground found on both sides, searched farther than a
 * fill does, and the distance d_s to the robot. NaN (unknown) where one side has none. */
TALUS_HD float sparsity(const LineSearch<RadialCells>& search, float robot_m, const Config& k)
{
  const int inner = search.next(search.place, false, k.sparsity_search_m);
  const int outer = search.next(search.place, true, k.sparsity_search_m);
  if (inner < 0 || outer < 0) return kNan;
  const float h_s = abs_of(
      search.store.ground_m[search.storage_at(inner)] -
      search.store.ground_m[search.storage_at(outer)]);
  const float ratio = h_s * k.inverse_step_threshold;
  if (h_s < k.step_threshold_m) return clamp01(1.0f - ratio);
  return clamp01(1.0f - ratio * k.sparsity_distance_m / robot_m);
}

}  // namespace talus::kernels
