#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace talus
{
/** The state of a cell and its last traversability. Heights are in the map frame; NaN: unknown. */
struct CellRecord
{
  /** The bytes of `evidence`, and how many of them, at its start, stay valid for longer than a few
   * frames, see clear_transient_evidence(). */
  static constexpr int kEvidenceBytes = 7, kLastingBytes = 5;

  /** Height of the ground, and the variance of its fused points, or of its fill. */
  float ground_m = NAN, ground_variance_m2 = NAN;
  /** Height of the top of what stands on it, and its variance. */
  float elevation_m = NAN, elevation_variance_m2 = NAN;
  float traversability = NAN;  //!< [0, 1]; NaN: not judged
  /** a CellState */
  std::uint8_t state = 0;
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

/** Cells of the global grid: cell (x, y) covers [x * resolution_m, ...) along x and y of the map
 * frame. */
struct CellRect
{
  /** The first cell along x and y. */
  std::int64_t min_cell_x = 0, min_cell_y = 0;
  /** Cells along x and y. */
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
  /** nullptr: none. */
  CellRecord* first = nullptr;
  /** The number of records. */
  std::size_t size = 0;

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
  /** The result of update(). */
  CellRecords records_before, records_after;
};

}  // namespace talus
