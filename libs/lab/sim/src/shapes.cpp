#include <talus/sim/geometry.h>
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

constexpr int kLeafShapes = 2;
constexpr double kSlack_m = 1e-9;  //!< of boxes, so that rounding hides no shape

void include(Bounds& box, const Bounds& other)
{
  const Vec3 &a = other.min_m, &b = other.max_m;
  box.min_m = {std::min(box.min_m.x, a.x), std::min(box.min_m.y, a.y), std::min(box.min_m.z, a.z)};
  box.max_m = {std::max(box.max_m.x, b.x), std::max(box.max_m.y, b.y), std::max(box.max_m.z, b.z)};
}

/** A ray as boxes are asked for it: by 1 / direction, where a division for each face would be most
 * of the work. */
struct Line
{
  explicit Line(const Ray& ray)
      : origin_m(ray.origin_m),
        per_m{inverse(ray.direction.x), inverse(ray.direction.y), inverse(ray.direction.z)}
  {
  }
  static double inverse(double d) { return d == 0 ? 1e300 : 1 / d; }

  /** Whether it runs through the box somewhere from 0 to `to`. */
  bool meets(const Bounds& box, double to) const
  {
    double from = 0;
    const auto clip = [&](double low, double high, double o, double inverse)
    {
      const double a = (low - o) * inverse, b = (high - o) * inverse;
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    };
    clip(box.min_m.x, box.max_m.x, origin_m.x, per_m.x);
    clip(box.min_m.y, box.max_m.y, origin_m.y, per_m.y);
    clip(box.min_m.z, box.max_m.z, origin_m.z, per_m.z);
    return from <= to;
  }

  Vec3 origin_m, per_m;
};

}  // namespace

Pose pose_from_axes(const Vec3& x_axis, const Vec3& y_axis, const Vec3& z_axis, const Vec3& t_m)
{
  Pose T;
  T.m = {x_axis.x, y_axis.x, z_axis.x, t_m.x,    x_axis.y, y_axis.y,
         z_axis.y, t_m.y,    x_axis.z, y_axis.z, z_axis.z, t_m.z};
  return T;
}

Pose pose_from_rpy(const Vec3& t_m, double roll_rad, double pitch_rad, double yaw_rad)
{
  const double cr = std::cos(roll_rad), sr = std::sin(roll_rad);
  const double cp = std::cos(pitch_rad), sp = std::sin(pitch_rad);
  const double cy = std::cos(yaw_rad), sy = std::sin(yaw_rad);
  return pose_from_axes(
      {cy * cp, sy * cp, -sp}, {cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr},
      {cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr}, t_m);
}

Pose compose(const Pose& T_a_b, const Pose& T_b_c)
{
  const auto axis = [&](int i) {
    return rotate(T_a_b, {T_b_c.m[i], T_b_c.m[4 + i], T_b_c.m[8 + i]});
  };
  return pose_from_axes(
      axis(0), axis(1), axis(2), transform(T_a_b, {T_b_c.x(), T_b_c.y(), T_b_c.z()}));
}

Pose inverse(const Pose& T_a_b)
{
  const auto& m = T_a_b.m;
  const Vec3 t = rotate_back(T_a_b, {T_a_b.x(), T_a_b.y(), T_a_b.z()});
  return pose_from_axes({m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, t * -1.0);
}

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

ShapeTree::ShapeTree(std::vector<Shape> shapes) : shapes_(std::move(shapes))
{
  if (!shapes_.empty()) build(0, static_cast<int>(shapes_.size()));
}

int ShapeTree::build(int first, int last)
{
  const int index = static_cast<int>(nodes_.size());
  Bounds box = bounds(shapes_[first]);
  for (int i = first + 1; i < last; ++i) include(box, bounds(shapes_[i]));
  const Vec3 slack{kSlack_m, kSlack_m, kSlack_m};
  nodes_.push_back({{box.min_m - slack, box.max_m + slack}, first, last - first, 0});
  if (last - first <= kLeafShapes) return index;

  const Vec3 size = box.max_m - box.min_m;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto center = [axis](const Shape& s) { return s.T_map_shape.m[4 * axis + 3]; };
  const int middle = (first + last) / 2;
  std::nth_element(
      shapes_.begin() + first, shapes_.begin() + middle, shapes_.begin() + last,
      [&](const Shape& a, const Shape& b) { return center(a) < center(b); });
  build(first, middle);
  const int right = build(middle, last);
  nodes_[index].count = 0;
  nodes_[index].right = right;
  return index;
}

template <typename F>
void ShapeTree::visit(const Ray& ray, const double& max_m, F f) const
{
  if (nodes_.empty()) return;
  const Line line(ray);
  int stack[64], top = 0;  // a balanced tree: its depth is log2 of the number of shapes
  stack[top++] = 0;
  while (top > 0)
  {
    const int index = stack[--top];
    const Node& node = nodes_[index];
    if (!line.meets(node.box, max_m)) continue;
    for (int i = 0; i < node.count; ++i) f(node.first + i);
    if (node.count > 0) continue;
    stack[top++] = node.right;
    stack[top++] = index + 1;
  }
}

std::optional<ShapeTree::Hit> ShapeTree::cast(
    const Ray& ray, double max_m, std::uint64_t chance, double time_s) const
{
  Hit best{max_m, nullptr};
  visit(
      ray, best.range_m,
      [&](int i)
      {
        if (!shapes_[i].is_there(time_s)) return;
        const auto range = first_hit(shapes_[i], ray, mix(chance, static_cast<std::uint64_t>(i)));
        if (range && *range < best.range_m) best = {*range, &shapes_[i]};
      });
  if (!best.shape) return std::nullopt;
  return best;
}

void ShapeTree::column(double x_m, double y_m, double time_s, std::vector<Span>& heights_m) const
{
  constexpr double kDeep_m = 1e5;  // below every world
  const double reach = 2 * kDeep_m;
  visit(
      {{x_m, y_m, -kDeep_m}, {0, 0, 1}}, reach,
      [&](int i)
      {
        if (shapes_[i].is_there(time_s) && !shapes_[i].grass)
          sim::column(shapes_[i], x_m, y_m, heights_m);
      });
}

}  // namespace talus::sim
