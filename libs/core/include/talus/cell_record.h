#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace talus
{
/** All that the map remembers of a cell, and how it was judged last. Heights are in the map frame;
 * NaN: unknown. */
struct CellRecord
{
  /** Bytes of `evidence`, and how many of them, the first, stay true when a cell is kept for longer
   * than a few frames, see forget_latest(). */
  static constexpr int kEvidenceBytes = 7, kLastingBytes = 5;

  /** Height of the ground, and its variance. */
  float ground_m = NAN, ground_variance_m2 = NAN;
  /** Height of the top of what stands on it, and its variance. */
  float elevation_m = NAN, elevation_variance_m2 = NAN;
  float traversability = NAN;  //!< [0, 1]; NaN: not judged
  /** a CellState */
  std::uint8_t state = 0;
  /** For the map alone: what hits, rays and the robot have shown. */
  std::uint8_t evidence[kEvidenceBytes] = {};
};

/** Ground heights that differ by more than this are those of two floors [m]. */
constexpr float kOtherFloor_m = 1.28f;

/** A cell is kept for later: what it says of the frames just before is forgotten. */
void forget_latest(CellRecord& record);

/** Cells of the global grid: cell (x, y) covers [x * resolution_m, ...) along x and y of the map
 * frame. */
struct CellRect
{
  /** The first cell along x and y. */
  std::int64_t min_cell_x = 0, min_cell_y = 0;
  /** Cells along x and y. */
  int width_cells = 0, height_cells = 0;

  /** Cells in all. */
  std::size_t size() const
  {
    return static_cast<std::size_t>(width_cells) * static_cast<std::size_t>(height_cells);
  }
};

/** Records in the memory of a map. They may be changed, and given back from there. */
struct CellRecords
{
  /** nullptr: none. */
  CellRecord* first = nullptr;
  /** How many. */
  std::size_t size = 0;

  /** The i-th, below size. */
  CellRecord& operator[](std::size_t i) const { return first[i]; }
  /** For range-based loops. */
  CellRecord* begin() const { return first; }
  /** For range-based loops. */
  CellRecord* end() const { return first + size; }
};

/** Cells that a frame hands over, see ElevationMapper::update(). */
struct FrameCells
{
  /** Which: in the window before the frame, and in its own. */
  std::vector<CellRect> before, after;
  /** What update() puts here. */
  CellRecords records_before, records_after;
};

}  // namespace talus
