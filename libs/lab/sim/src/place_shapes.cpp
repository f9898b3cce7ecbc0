#include "place_shapes.h"

#include <algorithm>

namespace talus::sim
{
void PlaceShapes::box(double x_m, double y_m, const Vec3& size_m, double yaw_rad, double lift_m)
{
  const double ground = ground_m(x_m, y_m), c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  double bottom = ground + lift_m;
  for (int corner = 0; lift_m == 0 && corner < 4; ++corner)
  {
    const double dx = 0.5 * size_m.x * (corner & 1 ? 1 : -1);
    const double dy = 0.5 * size_m.y * (corner & 2 ? 1 : -1);
    bottom = std::min(bottom, ground_m(x_m + c * dx - s * dy, y_m + s * dx + c * dy));
  }
  const double top = ground + lift_m + size_m.z;
  shapes_.push_back(make_box({x_m, y_m, bottom}, {size_m.x, size_m.y, top - bottom}, yaw_rad));
}

void PlaceShapes::post(double x_m, double y_m, double height_m, double radius_m, double lift_m)
{
  const double z = ground_m(x_m, y_m) + lift_m, sunk = lift_m == 0 ? radius_m : 0;
  shapes_.push_back(make_cylinder({x_m, y_m, z - sunk}, {x_m, y_m, z + height_m}, radius_m));
}

void PlaceShapes::stone(double x_m, double y_m, const Vec3& size_m, double yaw_rad)
{
  const double semi = 1.15 * size_m.z, z = ground_m(x_m, y_m) + size_m.z - semi;
  shapes_.push_back(make_ellipsoid({x_m, y_m, z}, {0.5 * size_m.x, 0.5 * size_m.y, semi}, yaw_rad));
}

}  // namespace talus::sim
