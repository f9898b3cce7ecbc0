#include <talus/baselines/rivals.h>

#include <algorithm>
#include <cmath>

namespace talus::baselines
{
namespace
{
/** The known cells around one, positions in cells from it. */
struct Neighbourhood
{
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  double z = 0, zz = 0, xz = 0, yz = 0;  //!< heights relative to the middle cell
  double max_difference_m = 0;

  void add(double dx, double dy, double dz)
  {
    n += 1, x += dx, y += dy, z += dz;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
    xz += dx * dz, yz += dy * dz, zz += dz * dz;
    max_difference_m = std::max(max_difference_m, std::abs(dz));
  }
};

Neighbourhood gather(const std::vector<float>& surface, int cells, int ix, int iy, int radius)
{
  Neighbourhood m;
  const float own = surface[iy * cells + ix];
  for (int y = std::max(iy - radius, 0); y <= std::min(iy + radius, cells - 1); ++y)
    for (int x = std::max(ix - radius, 0); x <= std::min(ix + radius, cells - 1); ++x)
    {
      const float h = surface[y * cells + x];
      if (h == h) m.add(x - ix, y - iy, h - own);
    }
  return m;
}

struct Plane
{
  double slope_rad = 0, rms_m = 0;
};

Plane fit(const Neighbourhood& m, double resolution_m)
{
  const double xx = m.xx - m.x * m.x / m.n, xy = m.xy - m.x * m.y / m.n;
  const double yy = m.yy - m.y * m.y / m.n, zz = m.zz - m.z * m.z / m.n;
  const double xz = m.xz - m.x * m.z / m.n, yz = m.yz - m.y * m.z / m.n;
  const double determinant = xx * yy - xy * xy;
  if (m.n < 3 || determinant < 1e-9) return {};
  const double gx = (xz * yy - yz * xy) / determinant, gy = (yz * xx - xz * xy) / determinant;
  const double residual = std::max(zz - gx * xz - gy * yz, 0.0);
  return {std::atan(std::hypot(gx, gy) / resolution_m), std::sqrt(residual / m.n)};
}

float judge_cell(const Neighbourhood& m, const Parameters& p)
{
  const Plane plane = fit(m, p.resolution_m);
  const double slope = 1 - plane.slope_rad / p.slope_threshold_rad;
  const double step = 1 - m.max_difference_m / p.step_threshold_m;
  const double roughness = 1 - plane.rms_m / p.roughness_threshold_m;
  if (slope <= 0 || step <= 0 || roughness <= 0) return 0.0f;
  return static_cast<float>(
      p.weight_slope * slope + p.weight_step * step + p.weight_roughness * roughness);
}

void judge(const std::vector<float>& surface, Surfaces& s, const Parameters& p)
{
  const int cells = s.window.cells;
  const int radius =
      std::max(static_cast<int>(std::lround(p.feature_radius_m / p.resolution_m)), 1);
  for (int iy = 0; iy < cells; ++iy)
    for (int ix = 0; ix < cells; ++ix)
    {
      const auto i = static_cast<std::size_t>(iy * cells + ix);
      if (surface[i] == surface[i])
        s.traversability[i] = judge_cell(gather(surface, cells, ix, iy, radius), p);
    }
}

}  // namespace

void judge_one_surface(Surfaces& s, const Parameters& p) { judge(s.elevation_m, s, p); }

void judge_two_surfaces(Surfaces& s, const Parameters& p)
{
  judge(s.ground_m, s, p);
  for (std::size_t i = 0; i < s.size(); ++i)
    if (s.elevation_m[i] - s.ground_m[i] > p.step_threshold_m) s.traversability[i] = 0.0f;
}

}  // namespace talus::baselines
