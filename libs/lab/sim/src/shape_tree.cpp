#include <talus/sim/random.h>
#include <talus/sim/shapes.h>

#include <algorithm>

namespace talus::sim
{
namespace
{
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
