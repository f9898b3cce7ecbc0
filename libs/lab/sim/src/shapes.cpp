#include <talus/sim/shapes.h>
#include <talus/sim/random.h>

#include <algorithm>
#include <limits>

namespace talus::sim
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/** Keeps of `span` what lies between the planes coordinate = -1 and +1. */
bool clip_slab(double origin, double direction, Span& span)
{
  if (direction == 0) return std::abs(origin) <= 1;
  const double a = (-1 - origin) / direction, b = (1 - origin) / direction;
  span.enter_m = std::max(span.enter_m, std::min(a, b));
  span.exit_m = std::min(span.exit_m, std::max(a, b));
  return span.enter_m < span.exit_m;
}

/** Keeps of `span` what lies where a t^2 + 2 b t + c <= 0. */
bool clip_quadric(double a, double b, double c, Span& span)
{
  if (a == 0) return c <= 0;
  const double disc = b * b - a * c;
  if (disc <= 0) return false;
  span.enter_m = std::max(span.enter_m, (-b - std::sqrt(disc)) / a);
  span.exit_m = std::min(span.exit_m, (-b + std::sqrt(disc)) / a);
  return span.enter_m < span.exit_m;
}

}  // namespace

Shape make_box(const Vec3& bottom_m, const Vec3& size_m, double yaw_rad)
{
  Shape s;
  s.kind = Shape::Kind::Box;
  s.half_m = size_m * 0.5;
  s.T_map_shape = pose_from_rpy(bottom_m + Vec3{0, 0, s.half_m.z}, 0, 0, yaw_rad);
  return s;
}

Shape make_cylinder(const Vec3& a_m, const Vec3& b_m, double radius_m)
{
  const Vec3 axis = normalized(b_m - a_m);
  const Vec3 helper = std::abs(axis.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 x = normalized(cross(helper, axis));
  Shape s;
  s.kind = Shape::Kind::Cylinder;
  s.half_m = {radius_m, radius_m, 0.5 * norm(b_m - a_m)};
  s.T_map_shape = pose_from_axes(x, cross(axis, x), axis, (a_m + b_m) * 0.5);
  return s;
}

Shape make_ellipsoid(const Vec3& center_m, const Vec3& semi_axes_m, double yaw_rad)
{
  Shape s;
  s.kind = Shape::Kind::Ellipsoid;
  s.half_m = semi_axes_m;
  s.T_map_shape = pose_from_rpy(center_m, 0, 0, yaw_rad);
  return s;
}

Bounds bounds(const Shape& s)
{
  const auto& m = s.T_map_shape.m;
  const auto reach = [&](int row)
  {
    return std::abs(m[row]) * s.half_m.x + std::abs(m[row + 1]) * s.half_m.y +
           std::abs(m[row + 2]) * s.half_m.z;
  };
  const Vec3 c{s.T_map_shape.x(), s.T_map_shape.y(), s.T_map_shape.z()};
  const Vec3 r{reach(0), reach(4), reach(8)};
  return {c - r, c + r};
}

std::optional<Span> intersect(const Shape& s, const Ray& ray)
{
  // In the frame of the shape, scaled to half extents of 1: ranges stay what they are.
  const Vec3 t{s.T_map_shape.x(), s.T_map_shape.y(), s.T_map_shape.z()};
  Vec3 o = rotate_back(s.T_map_shape, ray.origin_m - t);
  Vec3 d = rotate_back(s.T_map_shape, ray.direction);
  o = {o.x / s.half_m.x, o.y / s.half_m.y, o.z / s.half_m.z};
  d = {d.x / s.half_m.x, d.y / s.half_m.y, d.z / s.half_m.z};
  Span span{-kInfinity, kInfinity};
  bool inside = false;
  switch (s.kind)
  {
    case Shape::Kind::Box:
      inside = clip_slab(o.x, d.x, span) && clip_slab(o.y, d.y, span) && clip_slab(o.z, d.z, span);
      break;
    case Shape::Kind::Cylinder:
      inside = clip_slab(o.z, d.z, span) &&
               clip_quadric(
                   d.x * d.x + d.y * d.y, o.x * d.x + o.y * d.y, o.x * o.x + o.y * o.y - 1, span);
      break;
    case Shape::Kind::Ellipsoid:
      inside = clip_quadric(dot(d, d), dot(o, d), dot(o, o) - 1, span);
      break;
  }
  if (!inside) return std::nullopt;
  return span;
}

std::optional<double> first_hit(const Shape& shape, const Ray& ray, std::uint64_t chance)
{
  const auto span = intersect(shape, ray);
  if (!span || span->exit_m <= 0) return std::nullopt;
  if (shape.mean_free_path_m <= 0)
    return span->enter_m > 0 ? std::optional<double>(span->enter_m) : std::nullopt;
  const double depth = -shape.mean_free_path_m * std::log(1.0 - uniform(chance));
  const double range = std::max(0.0, span->enter_m) + depth;
  return range < span->exit_m ? std::optional<double>(range) : std::nullopt;
}

void column(const Shape& shape, double x_m, double y_m, std::vector<Span>& heights_m)
{
  const auto span = intersect(shape, {{x_m, y_m, 0}, {0, 0, 1}});
  if (span) heights_m.push_back({span->enter_m, span->exit_m, shape.mean_free_path_m > 0});
}

}  // namespace talus::sim
