#pragma once
#include <mrpt/poses/CPose3D.h>

#include <algorithm>
#include <cmath>

namespace talus::io
{
inline bool is_finite(const mrpt::poses::CPose3D& pose)
{
  const auto T = pose.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>();
  return std::all_of(T.begin(), T.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace talus::io
