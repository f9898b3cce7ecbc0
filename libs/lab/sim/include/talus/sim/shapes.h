#pragma once
#include <talus/sim/geometry.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace talus::sim
{
/** A convex body: a box, a cylinder or an ellipsoid, stretched and placed by its pose. */
struct Shape
{
  enum class Kind
  {
    Box,  //!< |x| <= half.x, |y| <= half.y, |z| <= half.z
    Cylinder,  //!< axis z, radii half.x and half.y, flat caps
    Ellipsoid
  };
  Kind kind = Kind::Box;
  Pose T_map_shape;
  Vec3 half_m;  //!< half of its extent along its own axes
  /** Foliage: mean depth [m] that a ray goes in before it meets a leaf; 0: solid. */
  double mean_free_path_m = 0;
  double reflectivity = 0.5;  //!< [0,1], becomes the intensity of its points
  /** Foliage that is no obstacle: rays meet it, a robot drives through it. */
  bool grass = false;
  /** It is there from one time until just before the other, since the start of the drive. */
  double from_s = -std::numeric_limits<double>::infinity();
  double until_s = std::numeric_limits<double>::infinity();

  bool is_there(double time_s) const { return from_s <= time_s && time_s < until_s; }
};

/** Upright box, yawed, with its bottom at `bottom_m`. */
Shape make_box(const Vec3& bottom_m, const Vec3& size_m, double yaw_rad);
/** Cylinder between the centres of its caps. */
Shape make_cylinder(const Vec3& a_m, const Vec3& b_m, double radius_m);
/** Ellipsoid with semi-axes, yawed. */
Shape make_ellipsoid(const Vec3& center_m, const Vec3& semi_axes_m, double yaw_rad);

/** Axis-aligned bounds in the map frame. */
struct Bounds
{
  Vec3 min_m, max_m;
};
Bounds bounds(const Shape& shape);

/** Where the whole line of a ray runs inside a shape, as ranges (negative: behind the origin);
 * nothing where it misses. */
struct Span
{
  double enter_m = 0, exit_m = 0;
  bool foliage = false;
};
std::optional<Span> intersect(const Shape& shape, const Ray& ray);

/** Range to where a ray from outside first meets the shape; `chance` (any hash of the ray) decides
 * how deep it goes into foliage. */
std::optional<double> first_hit(const Shape& shape, const Ray& ray, std::uint64_t chance);

/** Shapes in a tree of bounds, so that a ray asks only the few near it. */
class ShapeTree
{
 public:
  ShapeTree() = default;
  explicit ShapeTree(std::vector<Shape> shapes);

  /** The first of the shapes there at a time that a ray meets within `max_m`, and where. */
  struct Hit
  {
    double range_m = 0;
    const Shape* shape = nullptr;
  };
  std::optional<Hit> cast(const Ray& ray, double max_m, std::uint64_t chance, double time_s) const;

  /** Appends the heights [m] between which the vertical line at (x, y) is inside a shape that is
   * there at a time and no grass. */
  void column(double x_m, double y_m, double time_s, std::vector<Span>& heights_m) const;

  const std::vector<Shape>& shapes() const { return shapes_; }

 private:
  struct Node
  {
    Bounds box;
    int first = 0, count = 0;  //!< shapes of a leaf; count 0: an inner node
    int right = 0;  //!< right child of an inner node; the left one comes next
  };
  int build(int first, int last);
  template <typename F>
  void visit(const Ray& ray, const double& max_m, F f) const;

  std::vector<Shape> shapes_;
  std::vector<Node> nodes_;
};

/** Appends the heights between which the vertical line at (x, y) is inside a shape. */
void column(const Shape& shape, double x_m, double y_m, std::vector<Span>& heights_m);

}  // namespace talus::sim
