#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base_points.h"

namespace talus::hints
{
constexpr std::size_t kDirections = 120;  // around a sensor

/** How far a point is from the sensor, in the plane of the base. */
inline double away_m(const Vec3& p, const Vec3& sensor)
{
  return std::hypot(p.x - sensor.x, p.y - sensor.y);
}

inline std::size_t direction_of(const Vec3& p, const Vec3& sensor)
{
  const double turn = std::atan2(p.y - sensor.y, p.x - sensor.x) / (2 * M_PI) + 0.5;
  return std::min(static_cast<std::size_t>(turn * kDirections), kDirections - 1);
}

}  // namespace talus::hints
