#pragma once
#include <vector>

namespace talus::bench
{
/** Of an unordered sample; q in [0, 1]. */
double quantile(std::vector<double> sample, double q);

/** Processor time of all threads of this process so far [s]: time in which other processes had the
 * processor does not count. */
double process_cpu_s();

}  // namespace talus::bench
