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
    add_height(dx, dy, h);
  }
  TALUS_HD void add_height(float dx, float dy, float h)
  {
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
  /** What the neighbours of a cell, and the cell itself, say. */
  struct Neighbours
  {
    PlaneSums near, around;  //!< of 3 x 3 and of 5 x 5 cells
    int measured = 0;
  };

  TALUS_HD float told_m2(int ix, int iy, int storage_i, bool measured, float known_m2) const
  {
    Neighbours all = lie_together(ix, iy) ? together(storage_i, measured) : Neighbours{};
    if (!(all.measured > 0 && is_known(all.around.z))) all = one_by_one(ix, iy, storage_i);
    const float noise_m2 = all.around.mean_square_m2(), near_m2 = all.near.mean_square_m2();
    const float strays_m2 = noise_m2 + max_of(noise_m2 - near_m2, 0.0f);
    const auto met = static_cast<float>(all.measured);
    const float own_m2 = measured ? known_m2 / (met * met) : known_m2;
    return max_of(strays_m2 + own_m2, config->min_variance_m2);
  }
  /** Whether the rows of all neighbours follow one another in the store. */
  TALUS_HD bool lie_together(int ix, int iy) const
  {
    const int n = config->cells;
    const auto is_inside = [n](int at, int shift)
    {
      const int stored = at + shift - select(at + shift >= n, n, 0);
      return (at >= 2) & (at < n - 2) & (stored >= 2) & (stored < n - 2);
    };
    return is_inside(ix, frame->storage_x) && is_inside(iy, frame->storage_y);
  }
  /** The same sums as one_by_one() where the ground of all neighbours is known, else NaN in z. */
  TALUS_HD Neighbours together(int storage_i, bool counts_measured) const
  {
    Neighbours all;
    all.around.n = 25.0f, all.around.xx = all.around.yy = 50.0f;
    all.near.n = 9.0f, all.near.xx = all.near.yy = 6.0f;
    all.measured = 1;
    const float own_m = store.ground_m[storage_i];
    for (int dy = -2; dy <= 2; dy++)
      for (int dx = -2; dx <= 2; dx++)
      {
        const float rise_m = store.ground_m[storage_i + dy * config->cells + dx] - own_m;
        all.around.add_height(static_cast<float>(dx), static_cast<float>(dy), rise_m);
        if (dx * dx <= 1 && dy * dy <= 1)
          all.near.add_height(static_cast<float>(dx), static_cast<float>(dy), rise_m);
      }
    if (!counts_measured) return all;
    all.measured = 0;
    for (int dy = -2; dy <= 2; dy++)
      for (int dx = -2; dx <= 2; dx++)
        all.measured += select(store.state[storage_i + dy * config->cells + dx] == kMeasured, 1, 0);
    return all;
  }
  TALUS_HD Neighbours one_by_one(int ix, int iy, int storage_i) const
  {
    Neighbours all;
    const float own_m = store.ground_m[storage_i];
    const int n = config->cells;
    for (int dy = -2; dy <= 2; dy++)
      for (int dx = -2; dx <= 2; dx++)
      {
        const int x = ix + dx, y = iy + dy;
        if (x < 0 || y < 0 || x >= n || y >= n) continue;
        const int neighbour_i = storage_index(*frame, n, x, y);
        const float rise_m = store.ground_m[neighbour_i] - own_m;
        const auto to_x = static_cast<float>(dx), to_y = static_cast<float>(dy);
        all.around.add(to_x, to_y, rise_m, is_known(rise_m));
        if (dx * dx <= 1 && dy * dy <= 1) all.near.add(to_x, to_y, rise_m, is_known(rise_m));
        all.measured += select(store.state[neighbour_i] == kMeasured, 1, 0);
      }
    return all;
  }
};

}  // namespace talus::kernels
