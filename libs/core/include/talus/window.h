#pragma once
#include <cstdint>

namespace talus
{
/** Where the window lies. Cell (ix, iy) covers [min_x_m + ix*resolution_m, ...): ix grows with x,
 * iy with y. */
struct Window
{
  int cells = 0;  //!< along each side
  double resolution_m = 0;
  std::int64_t min_cell_x = 0,
               min_cell_y = 0;  //!< the first cell, counted in cells from the map's origin

  double min_x_m() const { return static_cast<double>(min_cell_x) * resolution_m; }
  double min_y_m() const { return static_cast<double>(min_cell_y) * resolution_m; }
};

}  // namespace talus
