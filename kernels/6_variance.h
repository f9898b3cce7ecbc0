#pragma once
#include "kernels/cell.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/math.h"

namespace talus::kernels
{
// What the map tells of the errors of its heights. It decides nothing: the stages weigh
// measurements by the variances in the store, which know the noise of points and no ground.

/** The plane through the ground of some neighbours, by least squares. Heights count from the cell
 * in the middle, so that little is lost in their squares. */
struct PlaneSums
{
  float n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, z = 0, xz = 0, yz = 0, zz = 0;

  /** A neighbour that does not count changes nothing. */
  TALUS_HD void add(float dx, float dy, float height_m, bool counts)
  {
    const float w = select(counts, 1.0f, 0.0f), h = select(counts, height_m, 0.0f);
    n += w, x += dx * w, y += dy * w;
    xx += dx * dx * w, xy += dx * dy * w, yy += dy * dy * w;
    z += h, xz += dx * h, yz += dy * h, zz += h * h;
  }
  /** The mean of the squared distances from the plane [m^2]; where the neighbours lie in a line,
   * from their mean. */
  TALUS_HD float mean_square_m2() const
  {
    const float axx = n * xx - x * x, axy = n * xy - x * y, ayy = n * yy - y * y;
    const float axz = n * xz - x * z, ayz = n * yz - y * z, azz = n * zz - z * z;
    const float area = axx * ayy - axy * axy, share = select(area > 0.5f, 1.0f / area, 0.0f);
    const float gx = (axz * ayy - ayz * axy) * share, gy = (ayz * axx - axz * axy) * share;
    return max_of(azz - gx * axz - gy * ayz, 0.0f) / (n * n);
  }
};

/** The variance of the ground of each cell, window order. What 5 x 5 cells stray from a plane is
 * noise, and relief that the cell has within itself, too; by how much this is more than what 3 x 3
 * cells stray, relief grows with the distance, and counts twice. A fill and presumed ground add
 * what they do not know, see variance_of_fill(). Where no neighbour was measured, the variance of
 * the cell's own measurements is all that there is; it says little beside what neighbours say. */
struct TellVariance
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  float* variance_m2;

  TALUS_HD void operator()(int ix, int iy) const
  {
    const int n = config->cells, storage_i = storage_index(*frame, n, ix, iy);
    const float known_m2 = store.ground_var_m2[storage_i];
    const bool known = store.state[storage_i] != kUnknown;
    variance_m2[iy * n + ix] =
        known ? told_m2(ix, iy, storage_i, store.state[storage_i] == kMeasured, known_m2)
              : known_m2;
  }

 private:
  TALUS_HD float told_m2(int ix, int iy, int storage_i, bool measured, float known_m2) const
  {
    PlaneSums near, around;
    float met = 0;  // neighbours that were measured, and the cell itself
    const float own_m = store.ground_m[storage_i];
    for (int dy = -2; dy <= 2; dy++)
      for (int dx = -2; dx <= 2; dx++)
      {
        const int x = ix + dx, y = iy + dy, n = config->cells;
        if (x < 0 || y < 0 || x >= n || y >= n) continue;
        const int neighbour_i = storage_index(*frame, n, x, y);
        const float rise_m = store.ground_m[neighbour_i] - own_m;
        const auto to_x = static_cast<float>(dx), to_y = static_cast<float>(dy);
        around.add(to_x, to_y, rise_m, is_known(rise_m));
        met += select(store.state[neighbour_i] == kMeasured, 1.0f, 0.0f);
        if (dx * dx <= 1 && dy * dy <= 1) near.add(to_x, to_y, rise_m, is_known(rise_m));
      }
    const float noise_m2 = around.mean_square_m2(), near_m2 = near.mean_square_m2();
    const float strays_m2 = noise_m2 + max_of(noise_m2 - near_m2, 0.0f);
    const float own_m2 = measured ? known_m2 / (met * met) : known_m2;
    return max_of(strays_m2 + own_m2, config->min_variance_m2);
  }
};

}  // namespace talus::kernels
