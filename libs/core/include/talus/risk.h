#pragma once
#include <talus/map_view.h>

#include <vector>

namespace talus
{
/** The probability that a cell is impassable, [0,1], for each cell of the window: an optional layer
 * that is computed when somebody asks, in closed form from layers of the map (slope, step,
 * roughness, traversability and variance). 1 where the map says impassable; NaN where it did not
 * judge.
 *
 * Elsewhere it is the probability that slope, step or roughness (eq. 10 to 12) exceeds its
 * threshold, if the heights around err as the variance of the cell says. It is an approximation:
 * - Errors are normal, those of neighbours independent and as large as that of the cell. A fill
 *   errs like its neighbours, so that its slope errs less, and the risk is too large.
 * - The three are taken for independent: the risk is 1 - P(slope) P(step) P(roughness).
 * - The slope of a step that the robot takes does not count, as in the traversability.
 * - What lies more than a threshold below its mean counts as one threshold below.
 * - What rays and hits show (objects, drops, what was never proved to be free) is in the
 *   traversability only.
 *
 * Same bits for the same map. Throws as MapView::layer(). */
std::vector<float> risk(const MapView& map);

}  // namespace talus
