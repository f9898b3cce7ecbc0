#pragma once
#include "scene.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace talus::test
{
/** Scans whose coordinates come from + - * / and comparisons alone, which IEEE rounds in one way:
 * every compiler and every processor makes the same bits of them. */
class ExactScene
{
 public:
  /** Ground heights [m] along x, joined by straight lines; level before the first and after the
   * last. x ascends. */
  std::vector<std::array<double, 2>> profile{{{0, 0}}};
  std::vector<Box> boxes;

  /** What a scanner with `beams` rings of `azimuths` rays sees. `T` is its pose, ring slopes (rise
   * over run) go from `lowest` to `highest`. Each height errs by up to `noise_m`. */
  Scan scan(
      const Pose& T, int azimuths, int beams, double lowest, double highest, Random& random,
      double noise_m) const
  {
    Scan s;
    s.pose_ = T;
    for (int b = 0; b < beams; b++)
      for (int a = 0; a < azimuths; a++)
      {
        const auto [cosine, sine] = direction(a, azimuths);
        const double slope = lowest + (highest - lowest) * b / (beams - 1);
        const double local[3] = {cosine, sine, slope};
        const double range = nearest_hit(T, local);
        const double error_m = random.uniform(-noise_m, noise_m);
        if (!(range < kFarthest_m)) continue;
        s.x_.push_back(static_cast<float>(range * local[0]));
        s.y_.push_back(static_cast<float>(range * local[1]));
        s.z_.push_back(static_cast<float>(range * local[2] + error_m));
      }
    return s;
  }

  /** Turned to the left by the angle whose half has the tangent `yaw`, then nose down by that of
   * `pitch`. */
  static Pose pose(double x_m, double y_m, double z_m, double yaw = 0, double pitch = 0)
  {
    const auto [cy, sy] = turn(yaw);
    const auto [cp, sp] = turn(pitch);
    Pose T;
    T.m = {cy * cp, -sy, cy * sp, x_m, sy * cp, cy, sy * sp, y_m, -sp, 0, cp, z_m};
    return T;
  }

 private:
  static constexpr double kFarthest_m = 30;

  /** Cosine and sine of the angle whose half has the tangent t. */
  static std::array<double, 2> turn(double t)
  {
    return {(1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)};
  }

  /** Ray a of n, quarter by quarter. */
  static std::array<double, 2> direction(int a, int n)
  {
    const int quarter = 4 * a / n;
    const auto [c, s] = turn((4.0 * a + 1.5 - static_cast<double>(quarter) * n) / n * 0.41);
    const std::array<double, 2> turned[4] = {{c, s}, {-s, c}, {-c, -s}, {s, -c}};
    return turned[std::min(quarter, 3)];
  }

  double nearest_hit(const Pose& T, const double* local) const
  {
    double o[3], d[3];
    for (std::size_t i = 0; i < 3; i++)
    {
      const double* row = &T.m[4 * i];
      o[i] = row[3];
      d[i] = row[0] * local[0] + row[1] * local[1] + row[2] * local[2];
    }
    double nearest = ground_hit(o, d);
    for (const Box& box : boxes) nearest = std::min(nearest, Scan::hit(box, o, d));
    return nearest;
  }

  /** Where the ray first meets a stretch of the profile from above. */
  double ground_hit(const double* o, const double* d) const
  {
    constexpr double kFar_m = 1e6;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i <= profile.size(); i++)
    {
      const double x0 = i ? profile[i - 1][0] : -kFar_m;
      const double z0 = i ? profile[i - 1][1] : profile[0][1];
      const double x1 = i < profile.size() ? profile[i][0] : kFar_m;
      const double z1 = i < profile.size() ? profile[i][1] : z0;
      const double rise = (z1 - z0) / (x1 - x0);
      const double falls = rise * d[0] - d[2], above = o[2] - z0 - rise * (o[0] - x0);
      if (!(falls > 0) || above < 0) continue;
      const double t = above / falls, x = o[0] + t * d[0];
      if (x >= x0 && x <= x1) nearest = std::min(nearest, t);
    }
    return nearest;
  }
};

}  // namespace talus::test
