#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace talus
{
/** The state of a cell and its last traversability. Heights are in the map frame; NaN: unknown. */
struct CellRecord
{
  /** The bytes of `evidence`; at its start those that last, see clear_transient_evidence(). */
  static constexpr int kEvidenceBytes = 7, kLastingBytes = 5;

  /** Height of the ground, and the variance of its fused points, or of its fill. */
  float ground_m = NAN, ground_variance_m2 = NAN;
  /** Height of the top of what stands on it, and its variance. */
  float elevation_m = NAN, elevation_variance_m2 = NAN;
  float traversability = NAN;  //!< [0, 1]; NaN: not judged
  std::uint8_t state = 0;  //!< a CellState
  /** Evidence of hits, rays and the robot, for the map alone. */
  std::uint8_t evidence[kEvidenceBytes] = {};
};

/** Ground heights that differ by more than this belong to two floors [m]. */
constexpr float kOtherFloor_m = 1.28f;

/** Whether the robot got there over passable cells, as in Layer::Reached. */
bool is_reached(const CellRecord& record);
/** Says so of a cell. */
void set_reached(CellRecord& record);

/** Clears the evidence of the latest frames, for a cell that is stored for later. */
void clear_transient_evidence(CellRecord& record);

/** Cells of the global grid: cell (x, y) begins at (x, y) * resolution_m in the map frame. */
struct CellRect
{
  /** the first cell along x and y */
  std::int64_t min_cell_x = 0, min_cell_y = 0;
  /** cells along x and y */
  int width_cells = 0, height_cells = 0;

  /** The number of cells. */
  std::size_t size() const
  {
    return static_cast<std::size_t>(width_cells) * static_cast<std::size_t>(height_cells);
  }
};

/** Records in the memory of a map. They may be changed in place and given back. */
struct CellRecords
{
  CellRecord* first = nullptr;  //!< nullptr: none
  std::size_t size = 0;  //!< the number of records

  /** The i-th, below size. */
  CellRecord& operator[](std::size_t i) const { return first[i]; }
  /** For range-based loops. */
  CellRecord* begin() const { return first; }
  /** For range-based loops. */
  CellRecord* end() const { return first + size; }
};

/** The cells that a frame hands over, see ElevationMapper::update(). */
struct FrameCells
{
  /** The wanted cells: in the window before the frame, and in that of the frame. */
  std::vector<CellRect> before, after;
  /** the result of update() */
  CellRecords records_before, records_after;
};

/** The window: cell (ix, iy) covers [min_x_m + ix * resolution_m, ...) along x, and so along y. */
struct Window
{
  int cells = 0;  //!< along each side
  double resolution_m = 0;  //!< side of a cell [m]
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
