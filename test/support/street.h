#pragma once
#include "scene.h"

#include <cmath>
#include <vector>

namespace talus::test
{
/** Noise on the heights; here and there NaN, infinity or a zero-range return. */
inline void spoil(Scan& s, Random& random, double noise_m = 0.02)
{
  for (std::size_t k = 0; k < s.z_.size(); k++)
  {
    if (noise_m > 0) s.z_[k] += static_cast<float>(random.uniform(-noise_m, noise_m));
    const auto luck = random.bits() % 400;
    if (luck == 0) s.x_[k] = std::nanf("");
    if (luck == 1) s.y_[k] = INFINITY;
    if (luck == 2) s.x_[k] = s.y_[k] = s.z_[k] = 0;
  }
}

/** A wall, a table, a kerb, a post, a beam overhead, and a car with windows above its doors. */
inline std::vector<Box> yard()
{
  return {{{2, 0.5, 0}, {2.3, 0.9, 0.5}},   {{4, -1, 0.75}, {4.6, 1, 0.8}},
          {{1, -2, 0}, {9, -1.95, 1.0}},    {{3.02, -0.6, 0}, {3.06, -0.56, 1.2}},
          {{6, -0.5, 0}, {6.5, 0.5, 0.08}}, {{7, -3, 0.35}, {7.2, 3, 0.45}},
          {{1.5, 2, 0.2}, {3.5, 3, 0.75}},  {{1.8, 2.12, 0.75}, {3.2, 2.9, 1.3}}};
}
/** With somebody who walks through it all, a platform, and a trailer that is drawn away. */
inline std::vector<Box> street(double walked_m)
{
  std::vector<Box> boxes = yard();
  boxes.push_back({{5 - walked_m, 1.2, 0}, {5.4 - walked_m, 1.5, 1.4}});
  boxes.push_back({{-3, -3, -0.4}, {-2, 3, 0.05}});
  boxes.push_back({{4.5 - walked_m, -1.5, 0.2}, {5.3 - walked_m, -0.9, 0.55}});
  return boxes;
}

/** What is seen from a position in the street, partly spoilt. */
inline Scan street_scan(
    double x_m, double y_m, double walked_m, int azimuths, int beams, Random& random)
{
  Scan s(x_m, y_m, 0.7);
  s.cast(street(walked_m), azimuths, -0.6, 0.1, beams);
  spoil(s, random);
  return s;
}

inline Scan drive_frame(int i, Random& random)
{
  const double x_m = 0.031 * i, y_m = 0.4 * std::sin(0.05 * i);
  if (i % 17 == 5) return Scan(x_m, y_m, 0.7);
  return street_scan(x_m, y_m, 0.02 * i, 360, 24, random);
}

}  // namespace talus::test
