#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace talus
{
/** The position of the window. Cell (ix, iy) covers [min_x_m + ix*resolution_m, ...): ix grows with
 * x, iy with y. */
struct Window
{
  int cells = 0;  //!< along each side
  /** Side of a cell [m]. */
  double resolution_m = 0;
  /** the first cell, counted in cells from the map's origin */
  std::int64_t min_cell_x = 0, min_cell_y = 0;

  /** Left border, map frame [m]. */
  double min_x_m() const { return static_cast<double>(min_cell_x) * resolution_m; }
  /** Lower border, map frame [m]. */
  double min_y_m() const { return static_cast<double>(min_cell_y) * resolution_m; }

  /** Index in each layer of the cell at a position in the map frame [m]; empty outside of the
   * window and for a position that is not finite. */
  std::optional<std::size_t> index_at(double x_m, double y_m) const
  {
    const double ix = std::floor(x_m / resolution_m) - static_cast<double>(min_cell_x);
    const double iy = std::floor(y_m / resolution_m) - static_cast<double>(min_cell_y);
    if (!(ix >= 0 && iy >= 0 && ix < cells && iy < cells)) return std::nullopt;
    return static_cast<std::size_t>(iy) * static_cast<std::size_t>(cells) +
           static_cast<std::size_t>(ix);
  }
};

}  // namespace talus
