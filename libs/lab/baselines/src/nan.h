#pragma once

#include <limits>

namespace talus::baselines
{
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
}  // namespace talus::baselines
