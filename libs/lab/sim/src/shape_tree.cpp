#include <talus/sim/random.h>
#include <talus/sim/shapes.h>

#include <algorithm>

namespace talus::sim
{
namespace
{
constexpr int kLeafShapes = 2;

double axis_of(const Vec3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

void include(Bounds& box, const Bounds& other)
{
  const Vec3 &a = other.min_m, &b = other.max_m;
  box.min_m = {std::min(box.min_m.x, a.x), std::min(box.min_m.y, a.y), std::min(box.min_m.z, a.z)};
  box.max_m = {std::max(box.max_m.x, b.x), std::max(box.max_m.y, b.y), std::max(box.max_m.z, b.z)};
}

/** Whether the line of a ray runs through the box somewhere in [from, to]. */
bool meets(const Bounds& box, const Ray& ray, double from, double to)
{
  for (int axis = 0; axis < 3; ++axis)
  {
    const double o = axis_of(ray.origin_m, axis), d = axis_of(ray.direction, axis);
    const double low = axis_of(box.min_m, axis), high = axis_of(box.max_m, axis);
    if (d == 0)
    {
      if (o < low || o > high) return false;
      continue;
    }
    const double a = (low - o) / d, b = (high - o) / d;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
    if (from > to) return false;
  }
  return true;
}

}  // namespace

ShapeTree::ShapeTree(std::vector<Shape> shapes) : shapes_(std::move(shapes))
{
  if (!shapes_.empty()) build(0, static_cast<int>(shapes_.size()));
}

int ShapeTree::build(int first, int last)
{
  const int index = static_cast<int>(nodes_.size());
  Bounds box = bounds(shapes_[first]);
  for (int i = first + 1; i < last; ++i) include(box, bounds(shapes_[i]));
  nodes_.push_back({box, first, last - first, 0});
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
  int stack[64], top = 0;  // a balanced tree: its depth is log2 of the number of shapes
  stack[top++] = 0;
  while (top > 0)
  {
    const int index = stack[--top];
    const Node& node = nodes_[index];
    if (!meets(node.box, ray, 0.0, max_m)) continue;
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
