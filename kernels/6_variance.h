#pragma once
#include "kernels/cell.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/lines.h"
#include "kernels/math.h"

namespace talus::kernels
{
// What the map states about the errors of its heights. It decides nothing: the stages weigh
// measurements by the variances in the store, which know the noise of points and no ground.

/** Distance in cells to the two cells before and after, from whose mean a cell deviates: a slope
 * cancels, noise and relief stay. Of white noise a difference has six times the variance. */
constexpr int kStrayPlaces = 2;
constexpr float kStrayVariance = 6.0f;
/** Frames do not average out what a beam errs along its ring: where one axis alone is known,
 * heights err three times as much, where none is, by 0.2 degrees; chosen on half of the labelled
 * scans. */
constexpr float kBesideRing = 3.0f, kBeamBias_rad = 0.0035f;
/** Cells beyond these of all sides are not asked by TellVariance. */
constexpr int kAskedPlaces = kStrayPlaces + 1;

/** Copies measured ground to window order, where TellVariance reads it. */
struct LayOutGround
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  LineGrid grid;
  float* ground_m;  //!< by place of the grid; NaN: not measured, as kAskedPlaces around the window

  TALUS_HD void operator()(int ix, int iy, int storage_i) const
  {
    const bool measured = store.state[storage_i] == kMeasured;
    ground_m[grid.at(ix, iy)] = select(measured, store.ground_m[storage_i], kNan);
  }
  TALUS_HD void operator()(int ix, int iy) const
  {
    (*this)(ix, iy, storage_index(*frame, config->cells, ix, iy));
  }
};

/** Mean of the squares of some differences. */
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
  /** 0 if there are none. */
  TALUS_HD float mean() const { return sum / max_of(n, 1.0f); }
};

/** The variance of the ground of each cell, window order: the mean square of what 3 x 3 cells stray
 * along the window's x axis or its y axis, whichever is more. Fills and presumed ground add what
 * they do not know, see variance_of_fill(); a cell that stands alone, what it was measured with. */
struct TellVariance
{
  LayOutGround laid_out;
  float* variance_m2;

  TALUS_HD void operator()(int ix, int iy, int storage_i) const
  {
    const float stored_m2 = laid_out.store.ground_var_m2[storage_i];
    const int state = laid_out.store.state[storage_i];
    const float* const at = laid_out.ground_m + laid_out.grid.at(ix, iy);
    MeanSquare along_x, along_y;
    add_rows(along_x, at, kStrayPlaces);
    add_rows(along_y, at, kStrayPlaces * laid_out.grid.pitch);
    const bool both = along_x.n * along_y.n > 0.0f, alone = along_x.n + along_y.n == 0.0f;
    const float share = select(both, 1.0f, kBesideRing * kBesideRing) / kStrayVariance;
    const float scatter_m2 = share * max_of(along_x.mean(), along_y.mean());
    const float bias_m = kBeamBias_rad * laid_out.config->resolution_m;
    const float x_m = static_cast<float>(ix - laid_out.grid.half) * bias_m;
    const float y_m = static_cast<float>(iy - laid_out.grid.half) * bias_m;
    const float own_m2 = select(alone, stored_m2 + x_m * x_m + y_m * y_m, 0.0f);
    const float told_m2 = scatter_m2 + select(state != kMeasured, stored_m2, own_m2);
    variance_m2[iy * laid_out.config->cells + ix] =
        select(state != kUnknown, max_of(told_m2, laid_out.config->min_variance_m2), kNan);
  }
  TALUS_HD void operator()(int ix, int iy) const
  {
    (*this)(ix, iy, storage_index(*laid_out.frame, laid_out.config->cells, ix, iy));
  }

 private:
  TALUS_HD void add_rows(MeanSquare& mean, const float* middle, int to) const
  {
    add_row(mean, middle - laid_out.grid.pitch, to);
    add_row(mean, middle, to);
    add_row(mean, middle + laid_out.grid.pitch, to);
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
