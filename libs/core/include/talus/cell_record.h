#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace talus
{
/** All that the map remembers of a cell, and how it was judged last. Heights are in the map frame;
 * NaN: unknown. What is not a height is for the map alone, see kernels/cell.h. */
struct CellRecord
{
  float ground_m = NAN, ground_variance_m2 = NAN;
  float elevation_m = NAN, elevation_variance_m2 = NAN;
  float traversability = NAN;  //!< [0, 1]; NaN: not judged
  std::uint8_t state = 0;  //!< a CellState
  std::int8_t persistence = 0;
  std::uint8_t ray_evidence = 0, extent = 0, footing = 0;
};

/** Cells of the global grid: cell (x, y) covers [x * resolution_m, ...) along x and y of the map
 * frame. */
struct CellRect
{
  std::int64_t min_cell_x = 0, min_cell_y = 0;
  int width_cells = 0, height_cells = 0;

  std::size_t size() const
  {
    return static_cast<std::size_t>(width_cells) * static_cast<std::size_t>(height_cells);
  }
};

/** Records in the memory of a map. They may be changed, and given back from there. */
struct CellRecords
{
  CellRecord* first = nullptr;
  std::size_t size = 0;

  CellRecord& operator[](std::size_t i) const { return first[i]; }
  CellRecord* begin() const { return first; }
  CellRecord* end() const { return first + size; }
};

/** Cells that a frame hands over, see ElevationMapper::update(). */
struct FrameCells
{
  std::vector<CellRect> before, after;  //!< which: in the window before the frame, and in its own
  CellRecords records_before, records_after;  //!< what update() puts here
};

}  // namespace talus
