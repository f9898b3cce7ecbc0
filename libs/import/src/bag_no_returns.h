#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "point_fields.h"

namespace talus::import
{
/** Where the first clouds of a sensor all have a point, bit by bit, that stands alone or comes
 * several times: a driver that brings its points into another frame puts there what gave no return.
 * At the origin the map leaves these out by their range. */
class NoReturns
{
 public:
  /** False: these were enough. */
  bool add(const ScanFile& cloud);
  /** None where they are so many that nothing moves in front of an exact sensor. */
  std::vector<std::array<double, 3>> places() const;

 private:
  std::size_t clouds_ = 0;
  std::vector<std::array<double, 3>> places_;  //!< of all clouds so far
};

}  // namespace talus::import
