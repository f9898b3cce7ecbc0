#pragma once
#include "kernels/config.h"
#include "kernels/math.h"

namespace talus::kernels
{
// Lines from the middle of the window, the robot's base, to its border, which the line search of a
// cell visits. A ring is the Chebyshev distance in cells, so that all directions are alike.

/** Rings that a window of n cells needs around its central cell. */
TALUS_HD int line_rings(const Config& k) { return k.cells / 2; }
TALUS_HD int line_count(const Config& k) { return 8 * line_rings(k); }

/** A line from the central cell to a border cell, which has index `minor` in [-rings, rings). */
struct Line
{
  int side;
  int minor;
};

TALUS_HD Line line_from_index(int index, int rings)
{
  const int side = floor_div(index, 2 * rings);
  return {side, index - (2 * side + 1) * rings};
}

TALUS_HD int line_index(const Line& l, int rings) { return l.side * 2 * rings + l.minor + rings; }

/** Rounded offset of a line from its axis at a ring [cells]; `inverse` = 1 / (2 rings). */
TALUS_HD int line_aside(int minor, int ring, int rings, float inverse)
{
  return floor_div(2 * minor * ring + rings, 2 * rings, inverse);
}

/** The line that passes a cell other than the central one. */
TALUS_HD Line line_through(int dx, int dy, int ring, int rings)
{
  int side = 3, minor = dx;
  if (dx == ring && dy < ring)
    side = 0, minor = dy;
  else if (dy == ring && dx > -ring)
    side = 1, minor = -dx;
  else if (dx == -ring && dy > -ring)
    side = 2, minor = -dy;
  return {side, floor_div(2 * minor * rings + ring, 2 * ring)};
}

TALUS_HD float line_stretch(const Line& l, int rings)
{
  const float u = static_cast<float>(l.minor) / static_cast<float>(rings);
  return sqrtf(1.0f + u * u);
}

/** Distance from the sensor along its line to the cell at (dx, dy) != 0 [m]. */
TALUS_HD float distance_along_line(int dx, int dy, const Config& k)
{
  const int rings = line_rings(k), ring = max_of(abs_of(dx), abs_of(dy));
  const float cell_m = line_stretch(line_through(dx, dy, ring, rings), rings) * k.resolution_m;
  return static_cast<float>(ring) * cell_m;
}

/** A grid with the sensor's cell in its middle: for even cells one more row and column. */
struct LineGrid
{
  int half, side, pitch;

  TALUS_HD int at(int ix, int iy) const { return iy * pitch + ix; }
  TALUS_HD int middle() const { return at(half, half); }
};

/** The pitch is an odd number of cache lines, so that cells of a column do not share lines. */
TALUS_HD LineGrid line_grid(const Config& k)
{
  const int half = k.cells / 2, side = 2 * half + 1;
  return {half, side, (side + 31) / 32 * 32 + 16};
}

}  // namespace talus::kernels
