#pragma once
#include <talus/sim/ground.h>
#include <talus/sim/shapes.h>

#include <vector>

namespace talus::sim
{
/** Puts shapes on the ground, at the end of a list. */
class PlaceShapes
{
 public:
  /** Keeps references to both. */
  PlaceShapes(const Ground& ground, std::vector<Shape>& shapes) : ground_(ground), shapes_(shapes)
  {
  }

  double ground_m(double x_m, double y_m) const { return ground_.height_m(x_m, y_m); }
  Vec3 on_ground(const Vec3& p) const { return {p.x, p.y, ground_m(p.x, p.y)}; }

  /** A box whose top is lift + size.z above the ground at its centre. Without lift it reaches down
   * to the lowest ground below its corners, so that nothing shows under it on a slope. */
  void box(double x_m, double y_m, const Vec3& size_m, double yaw_rad, double lift_m);

  /** A vertical cylinder; without lift it reaches as deep into the ground as it is wide. */
  void post(double x_m, double y_m, double height_m, double radius_m, double lift_m);

  /** A stone that is buried a little deeper than its middle; size.z is what stands above the
   * ground. */
  void stone(double x_m, double y_m, const Vec3& size_m, double yaw_rad);

 private:
  const Ground& ground_;
  std::vector<Shape>& shapes_;
};

}  // namespace talus::sim
