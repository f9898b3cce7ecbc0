#pragma once
#include "scans.h"

#include <optional>
#include <vector>

namespace talus::bench
{
/** The least that any mapper must do for a frame: what each line's time is compared with. */
struct Load
{
  std::size_t points = 0;
  int cells = 0;  //!< along each side
  double resolution_m = 0;
  int layers = 0;  //!< that go back to the host
};

/** On one core: transform and bin the points of a scan, and pass once over the window. Median [s].
 */
double cpu_floor_s(const Load& load, const Scan& scan);

/** On the device: a graph with one upload of the points, as many empty kernels as a frame has
 * stages and passes, and one download of the layers; pinned memory. Median [s], or nothing where
 * there is no device. */
std::optional<double> cuda_floor_s(const Load& load);

/** Of an unordered sample; q in [0, 1]. */
double quantile(std::vector<double> sample, double q);

}  // namespace talus::bench
