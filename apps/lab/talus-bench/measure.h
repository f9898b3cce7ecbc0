#pragma once
#include <algorithm>
#include <cstddef>
#include <ctime>
#include <cmath>
#include <vector>

namespace talus::bench
{
/** Of an unordered sample; q in [0, 1]. */
inline double quantile(std::vector<double> sample, double q)
{
  const std::ptrdiff_t at = std::lround(q * static_cast<double>(sample.size() - 1));
  std::nth_element(sample.begin(), sample.begin() + at, sample.end());
  return sample[static_cast<std::size_t>(at)];
}

/** Processor time of all threads of this process so far [s]: time in which other processes had the
 * processor does not count. */
inline double process_cpu_s()
{
  std::timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace talus::bench
