#pragma once
#include <talus/baselines/method.h>

namespace talus::baselines
{
/** Fills `traversability` the way grid filters do on one surface, `elevation_m`: in the square
 * neighbourhood of feature_radius_m, unknown cells left out,
 * - slope: angle of the least-squares plane, over slope_threshold_rad;
 * - step: greatest height difference to the cell, over step_threshold_m;
 * - roughness: RMS distance from that plane, over roughness_threshold_m;
 * and their weighted sum, zero where any is zero (eq. 13 with unsigned features). Fewer than three
 * known cells: slope and roughness count as perfect. */
void judge_one_surface(Surfaces& surfaces, const Parameters& parameters);

/** The same for maps with a ground below the elevation: slope and step on `ground_m`, and blocked
 * where the elevation stands more than step_threshold_m above the ground. */
void judge_two_surfaces(Surfaces& surfaces, const Parameters& parameters);

}  // namespace talus::baselines
