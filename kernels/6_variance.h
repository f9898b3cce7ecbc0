#pragma once
#include "kernels/map.h"

namespace talus::kernels
{
// The estimated errors of the map's heights. They decide nothing: the stages weigh measurements by
// the variances in the store, which know the noise of points and no ground.

/** Distance in cells to the two cells before and after, from whose mean a cell deviates: a slope
 * cancels, noise and relief stay. Of white noise a difference has six times the variance. */
constexpr int kStrayCells = 2;
constexpr float kStrayVariance = 6.0f;
/** Frames do not average out what a beam errs along its ring: where one axis alone is known,
 * heights err three times as much, where none is, by 0.2 degrees; chosen on labelled scans. */
constexpr float kBesideRing = 3.0f, kBeamBias_rad = 0.0035f;
/** Cells beyond these of all sides are not read by EstimateVariance. */
constexpr int kAskedCells = kStrayCells + 1;

/** Copies measured ground to window order, where EstimateVariance reads it. */
struct LayOutGround
{
  const Map& m;

  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    const bool measured = m.cell.state[i] == kMeasured;
    m.sample_m[m.lines.at(ix, iy)] = select(measured, m.cell.ground_m[i], kNan);
  }
};

struct MeanSquare
{
  float sum = 0, n = 0;

  /** A difference that is not known changes nothing. */
  TALUS_HD void add(float difference)
  {
    const bool known = is_known(difference);
    const float d = select(known, difference, 0.0f);
    sum += d * d;
    n += select(known, 1.0f, 0.0f);
  }
  TALUS_HD float mean() const { return sum / max_of(n, 1.0f); }
};

/** The variance of the ground of each cell, window order: the mean square of what 3 x 3 cells stray
 * along the window's x axis or its y axis, whichever is more. Fills and presumed ground add what
 * they do not know, see variance_of_fill(); a cell that stands alone, what it was measured with. */
struct EstimateVariance
{
  const Map& m;

  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    const float stored_m2 = m.cell.ground_var_m2[i];
    const int state = m.cell.state[i];
    const float* const at = m.sample_m + m.lines.at(ix, iy);
    MeanSquare along_x, along_y;
    add_rows(along_x, at, kStrayCells);
    add_rows(along_y, at, kStrayCells * m.lines.pitch);
    const bool both = along_x.n * along_y.n > 0.0f, alone = along_x.n + along_y.n == 0.0f;
    const float share = select(both, 1.0f, kBesideRing * kBesideRing) / kStrayVariance;
    const float scatter_m2 = share * max_of(along_x.mean(), along_y.mean());
    const float bias_m = kBeamBias_rad * m.k.resolution_m;
    const float x_m = static_cast<float>(ix - m.lines.half) * bias_m;
    const float y_m = static_cast<float>(iy - m.lines.half) * bias_m;
    const float own_m2 = select(alone, stored_m2 + x_m * x_m + y_m * y_m, 0.0f);
    const float all_m2 = scatter_m2 + select(state != kMeasured, stored_m2, own_m2);
    m.out.variance[m.window_at(ix, iy)] =
        select(state != kUnknown, max_of(all_m2, m.k.min_variance_m2), kNan);
  }

 private:
  TALUS_HD void add_rows(MeanSquare& mean, const float* middle, int to) const
  {
    add_row(mean, middle - m.lines.pitch, to);
    add_row(mean, middle, to);
    add_row(mean, middle + m.lines.pitch, to);
  }
  /** Adds what three cells of a row stray; no loop, which compilers would not vectorise. */
  TALUS_HD static void add_row(MeanSquare& mean, const float* middle, int to)
  {
    mean.add(strays_m(middle - 1, to));
    mean.add(strays_m(middle, to));
    mean.add(strays_m(middle + 1, to));
  }
  TALUS_HD static float strays_m(const float* middle, int to)
  {
    return (middle[-to] - *middle) + (middle[to] - *middle);
  }
};

}  // namespace talus::kernels
