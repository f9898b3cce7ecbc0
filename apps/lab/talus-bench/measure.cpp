#include "measure.h"

#include <algorithm>
#include <cstddef>
#include <ctime>

namespace talus::bench
{
double quantile(std::vector<double> sample, double q)
{
  const auto at = static_cast<std::ptrdiff_t>(q * static_cast<double>(sample.size() - 1) + 0.5);
  std::nth_element(sample.begin(), sample.begin() + at, sample.end());
  return sample[static_cast<std::size_t>(at)];
}

double process_cpu_s()
{
  std::timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace talus::bench
