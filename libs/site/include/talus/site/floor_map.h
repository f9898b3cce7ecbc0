#pragma once
#include <talus/live_map.h>
#include <talus/site/site.h>

namespace talus::site
{
/** One floor of a site as one map: the layers elevation, ground elevation, variance, state,
 * traversability and sparsity, of which nothing is kept, in the least square window that holds all
 * that is known of it. Of a floor that is wider than `most_cells` the window has so many along each
 * side, and (x_m, y_m) in its middle. A window of 0 cells where nothing is known. */
MapSnapshot floor_map(
    Site& site, int floor, const Parameters& parameters, int most_cells, double x_m, double y_m);

}  // namespace talus::site
