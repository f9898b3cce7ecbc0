#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace talus::io
{
/** The smallest value that at least a fraction `q` (0..1) of all values does not exceed: 0.5 is the
 * median, 0.99 the p99. NaN for no values. */
template <typename T>
T quantile(std::vector<T> values, double q)
{
  if (values.empty()) return std::numeric_limits<T>::quiet_NaN();
  const double rank = std::ceil(q * static_cast<double>(values.size())) - 1;
  const auto last = static_cast<double>(values.size() - 1);
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(std::min(std::max(rank, 0.0), last));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

}  // namespace talus::io
