#pragma once
#include <talus/sim/world.h>

#include <optional>
#include <vector>

namespace talus::sim
{
/** Cells of a raster. Cell (ix, iy) covers [min_x_m + ix * resolution_m, ...), iy grows with y. */
struct TruthWindow
{
  double min_x_m = 0, min_y_m = 0;  //!< outer corner of cell (0, 0), map frame
  int cells_x = 0, cells_y = 0;
  double resolution_m = 0.05;
};

/** The window around an area and a margin, its borders on whole multiples of the resolution as
 * those of a map. Throws as truth() does. */
TruthWindow window_around(const Bounds& area, double margin_m, double resolution_m);

/** What counts as an obstacle. */
struct TruthOptions
{
  bool movers = true;  //!< false: the world as if they had never been there
  double clearance_m = 0.6;  //!< height of the robot
  double min_obstacle_m = 0.1;  //!< what stands lower than this can be driven over
  double max_slope_rad = 0.6;  //!< of the ground
  double max_step_m = 0.2;  //!< of a vertical face of the ground, or of a steep stretch
  /** Where floors are above each other, the ground of a cell is the highest of them that is no more
   * than max_step_m above this height; not given: what is below all decks. */
  std::optional<double> level_m;
  int samples = 5;  //!< a cell is judged from samples * samples points well inside it
};

/** What is really there, one float a cell, index = iy * cells_x + ix, heights in the map frame.
 *
 * At each sample of a cell the objects above are climbed from the ground: an object joins
 * what stands as long as its underside is no more than the clearance above the top of what is
 * below; at the first larger gap all that is above hangs.
 *
 * - `ground` [m]: the ground, or the deck on it, at the centre of the cell.
 * - `obstacle_top` [m]: highest top of what stands or hangs too low, also of what is low enough to
 * be driven over; NaN where there is nothing.
 * - `underside` [m]: lowest underside with more than 1 cm of air below it; NaN where nothing hangs.
 * - `label`: 0 (blocked) if at any sample what stands is higher than min_obstacle_m above
 *   the ground, if the mean gradient of the ground in the cell is steeper than max_slope_rad and
 *   a stretch through its centre that is so steep rises by more than max_step_m, or if a vertical
 *   face of the ground higher than that is in the cell or on its border. 1 (free) otherwise. NaN
 *   where the ground is not defined: beyond the border of a height image; the other layers are
 *   then NaN too.
 * - `covered`: of blocked cells, the share of the samples at which something stands higher
 * than min_obstacle_m, or, if that is more, beside which the ground is too steep; 0 in free cells.
 * - `solid`: share of the samples at which something stands that has neither air nor foliage
 * from the ground to its top.
 */
struct Truth
{
  TruthWindow window;
  std::vector<float> ground, obstacle_top, underside, label, covered, solid;
};

/** The truth at a time since the start of the drive. Throws std::runtime_error that says how large
 * the raster would be if its six layers need more than 2 GB, std::invalid_argument for fewer than
 * no cells, for fewer than one sample, and for a resolution or a limit of step or slope that is not
 * positive, or a slope of a right angle. */
Truth truth(
    const World& world, const TruthWindow& window, double time_s, const TruthOptions& options = {});

}  // namespace talus::sim
