#pragma once
#include "scene.h"

#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace talus::test
{
/** The points of a scan in another order. */
inline Scan shuffled(const Scan& s, Random& random)
{
  std::vector<std::size_t> order(s.x_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = order.size(); i > 1; i--) std::swap(order[i - 1], order[random.bits() % i]);
  Scan out = s;
  for (std::size_t i = 0; i < order.size(); i++)
  {
    out.x_[i] = s.x_[order[i]];
    out.y_[i] = s.y_[order[i]];
    out.z_[i] = s.z_[order[i]];
  }
  return out;
}

}  // namespace talus::test
