#include <talus/sim/random.h>

#include <algorithm>
#include <iomanip>
#include <map>
#include <sstream>

#include "world_parts.h"

namespace talus::sim
{
namespace
{
/** Makes the shapes of one entry after another. */
class Builder
{
 public:
  Builder(const Ground& ground, const RobotPath& path) : ground_(ground), path_(path) {}

  void box(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    put_box(at[0], at[1], f.vector("size_m", kPositive), yaw(f), lift(f));
  }

  void wall(const Fields& f)
  {
    const double height = f.number("height_m", kPositive);
    const double thickness = f.number_or("thickness_m", 0.1, kPositive);
    const Line line = line_of(f);
    limit_parts(f, "to_m", std::ceil(line.length_m));
    const int pieces = std::max(1, static_cast<int>(std::ceil(line.length_m)));
    const double piece_m = line.length_m / pieces;
    for (int i = 0; i < pieces; ++i)
    {
      const Vec3 p = line.at((i + 0.5) / pieces);
      put_box(p.x, p.y, {piece_m, thickness, height}, line.yaw_rad, 0);
    }
  }

  void post(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    put_post(
        at[0], at[1], f.number("height_m", kPositive), f.number("radius_m", kPositive), lift(f));
  }

  void posts(const Fields& f)
  {
    const int count = f.whole("count", 2, 1000);
    const Line line = line_of(f);
    for (int i = 0; i < count; ++i)
    {
      const Vec3 p = line.at(static_cast<double>(i) / (count - 1));
      put_post(p.x, p.y, f.number("height_m", kPositive), f.number("radius_m", kPositive), 0);
    }
  }

  void sphere(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    const double r = f.number("radius_m", kPositive), z = ground_m(at[0], at[1]) + lift(f);
    shapes.push_back(make_ellipsoid({at[0], at[1], z + r}, {r, r, r}, 0));
  }

  void rock(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    put_stone(at[0], at[1], f.vector("size_m", kPositive), yaw(f));
  }

  void rocks(const Fields& f)
  {
    const auto area = f.numbers("area_m", 4, kAny), size = f.numbers("size_m", 2, kPositive);
    const double clear = f.number_or("clear_m", 0.8, kNotNegative);
    Random random(static_cast<std::uint64_t>(f.whole_or("seed", 1, 0, 2000000000)));
    const int count = f.whole("count", 1, 10000);
    int made = 0;
    for (int tries = 0; made < count && tries < 100 * count; ++tries)
    {
      const double x = random.uniform(area[0], area[2]), y = random.uniform(area[1], area[3]);
      const double s = random.uniform(size[0], size[1]), turn = random.uniform(0, kPi);
      if (path_.distance_to_m(x, y) < clear + 0.5 * s) continue;
      put_stone(x, y, {s, s * random.uniform(0.6, 1), s * random.uniform(0.5, 0.9)}, turn);
      ++made;
    }
    if (made < count) f.fail("area_m", "has no room for the rocks away from the robot's path");
  }

  void foliage(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    leaves(f, at[0], at[1], f.vector("size_m", kPositive), lift(f));
  }

  void grass(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny), size = f.numbers("size_m", 2, kPositive);
    const double height = f.number("height_m", kPositive);
    const double depth = 1 / f.number_or("density_per_m", 2, kPositive);
    // In pieces, so that it follows the ground.
    const double columns = std::ceil(size[0]), rows = std::ceil(size[1]);
    limit_parts(f, "size_m", columns * rows);
    const double length = size[0] / columns, width = size[1] / rows, turn = yaw(f);
    for (double i = 0.5; i < columns; ++i)
      for (double j = 0.5; j < rows; ++j)
      {
        const double dx = i * length - 0.5 * size[0], dy = j * width - 0.5 * size[1];
        const double x = at[0] + dx * std::cos(turn) - dy * std::sin(turn);
        const double y = at[1] + dx * std::sin(turn) + dy * std::cos(turn);
        put_box(x, y, {length, width, height}, turn, 0);
        shapes.back().mean_free_path_m = depth;
        shapes.back().grass = true;
      }
  }

  void deck(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny), size = f.numbers("size_m", 2, kPositive);
    const double top = f.number("z_m", kAny),
                 thickness = f.number_or("thickness_m", 0.2, kPositive);
    shapes.push_back(
        make_box({at[0], at[1], top - thickness}, {size[0], size[1], thickness}, yaw(f)));
  }

  void tree(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    const double height = f.number("height_m", kPositive), r = f.number("radius_m", kPositive);
    const double crown = 2 * f.number("crown_m", kPositive);
    put_post(at[0], at[1], height, r, 0);
    leaves(f, at[0], at[1], {crown, crown, 0.8 * crown}, height - 0.1 * crown);
  }

  void branch(const Fields& f)
  {
    Vec3 from = f.vector("from_m", kAny), to = f.vector("to_m", kAny);
    for (Vec3* end : {&from, &to}) end->z += ground_m(end->x, end->y);
    if (norm(to - from) < 1e-3) f.fail("to_m", "must differ from from_m");
    shapes.push_back(make_cylinder(from, to, f.number("radius_m", kPositive)));
  }

  void beam(const Fields& f)
  {
    const Line line = line_of(f);
    const Vec3 p = line.at(0.5);
    const Vec3 size{
        line.length_m, f.number("width_m", kPositive), f.number("thickness_m", kPositive)};
    put_box(p.x, p.y, size, line.yaw_rad, f.number("underside_m", kPositive));
  }

  void table(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    const Vec3 size = f.vector("size_m", kPositive);
    const double top = f.number_or("thickness_m", 0.03, {1e-3, size.z});
    const double leg = f.number_or("leg_m", 0.05, kPositive), turn = yaw(f);
    put_box(at[0], at[1], {size.x, size.y, top}, turn, size.z - top);
    const double under = shapes.back().T_map_shape.z() - 0.5 * top;
    for (const double sx : {-0.5, 0.5})
      for (const double sy : {-0.5, 0.5})
      {
        const double dx = sx * (size.x - leg), dy = sy * (size.y - leg);
        const double x = at[0] + dx * std::cos(turn) - dy * std::sin(turn);
        const double y = at[1] + dx * std::sin(turn) + dy * std::cos(turn);
        const double height = std::max(1e-3, under - ground_m(x, y));
        put_box(x, y, {leg, leg, height}, turn, 0);
      }
  }

  void railing(const Fields& f)
  {
    const double height = f.number("height_m", kPositive);
    const double r = f.number_or("radius_m", 0.02, kPositive);
    const int bars = f.whole_or("bars", 2, 1, 20);
    const Line line = line_of(f);
    const double wanted = std::round(line.length_m / f.number_or("spacing_m", 1, kPositive));
    limit_parts(f, f.has("spacing_m") ? "spacing_m" : "to_m", 1 + wanted * (1 + bars));
    const int spans = std::max(1, static_cast<int>(wanted));
    for (int i = 0; i <= spans; ++i)
    {
      const Vec3 p = line.at(static_cast<double>(i) / spans);
      put_post(p.x, p.y, height, r, 0);
      for (int bar = 1; i > 0 && bar <= bars; ++bar)
      {
        const Vec3 before = line.at((i - 1.0) / spans);
        const Vec3 up{0, 0, height * bar / bars};
        shapes.push_back(make_cylinder(on_ground(before) + up, on_ground(p) + up, r));
      }
    }
  }

  std::vector<Shape> shapes;

 private:
  /** A straight line over the ground. */
  struct Line
  {
    Vec3 from;
    double dx, dy, length_m, yaw_rad;
    Vec3 at(double w) const { return {from.x + w * dx, from.y + w * dy, 0}; }
  };
  static Line line_of(const Fields& f)
  {
    const auto a = f.numbers("from_m", 2, kAny), b = f.numbers("to_m", 2, kAny);
    const double dx = b[0] - a[0], dy = b[1] - a[1];
    if (std::hypot(dx, dy) < 1e-3) f.fail("to_m", "must differ from from_m");
    return {{a[0], a[1], 0}, dx, dy, std::hypot(dx, dy), std::atan2(dy, dx)};
  }
  /** Of one object; more would take hours, or not fit. */
  static void limit_parts(const Fields& f, const std::string& key, double parts)
  {
    constexpr double kMaxParts = 10000;
    if (parts <= kMaxParts) return;
    std::ostringstream what;
    what << "makes " << std::setprecision(15) << parts << " parts, the limit is " << kMaxParts
         << ": take a shorter line or fewer parts";
    f.fail(key, what.str());
  }
  static double yaw(const Fields& f) { return radians(f.number_or("yaw_deg", 0, kAny)); }
  static double lift(const Fields& f) { return f.number_or("lift_m", 0, kAny); }

  void leaves(const Fields& f, double x, double y, const Vec3& size, double lift_m)
  {
    const std::string form = f.text_or("form", "ellipsoid");
    if (form != "ellipsoid" && form != "box") f.fail("form", "must be ellipsoid or box");
    if (form == "box")
      put_box(x, y, size, yaw(f), lift_m);
    else
      shapes.push_back(
          make_ellipsoid({x, y, ground_m(x, y) + lift_m + 0.5 * size.z}, size * 0.5, yaw(f)));
    shapes.back().mean_free_path_m = f.number_or("mean_free_path_m", 0.1, kPositive);
  }

  double ground_m(double x_m, double y_m) const { return ground_.height_m(x_m, y_m); }
  Vec3 on_ground(const Vec3& p) const { return {p.x, p.y, ground_m(p.x, p.y)}; }

  /** A box whose top is lift + size.z above the ground at its centre. Without lift it reaches down
   * to the lowest ground below its corners, so that nothing shows under it on a slope. */
  void put_box(double x_m, double y_m, const Vec3& size_m, double yaw_rad, double lift_m)
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
    shapes.push_back(make_box({x_m, y_m, bottom}, {size_m.x, size_m.y, top - bottom}, yaw_rad));
  }

  /** A vertical cylinder; without lift it reaches as deep into the ground as it is wide. */
  void put_post(double x_m, double y_m, double height_m, double radius_m, double lift_m)
  {
    const double z = ground_m(x_m, y_m) + lift_m, sunk = lift_m == 0 ? radius_m : 0;
    shapes.push_back(make_cylinder({x_m, y_m, z - sunk}, {x_m, y_m, z + height_m}, radius_m));
  }

  /** A stone that is buried a little deeper than its middle; size.z is what shows. */
  void put_stone(double x_m, double y_m, const Vec3& size_m, double yaw_rad)
  {
    const double semi = 1.15 * size_m.z, z = ground_m(x_m, y_m) + size_m.z - semi;
    shapes.push_back(
        make_ellipsoid({x_m, y_m, z}, {0.5 * size_m.x, 0.5 * size_m.y, semi}, yaw_rad));
  }

  const Ground& ground_;
  const RobotPath& path_;
};

struct Kind
{
  const char* keys;  //!< besides reflectivity, from_s and until_s
  void (Builder::*make)(const Fields&);
};

const std::map<std::string, Kind> kKinds{
    {"box", {"at_m size_m yaw_deg lift_m", &Builder::box}},
    {"wall", {"from_m to_m height_m thickness_m", &Builder::wall}},
    {"post", {"at_m height_m radius_m lift_m", &Builder::post}},
    {"posts", {"from_m to_m count height_m radius_m", &Builder::posts}},
    {"sphere", {"at_m radius_m lift_m", &Builder::sphere}},
    {"rock", {"at_m size_m yaw_deg", &Builder::rock}},
    {"rocks", {"area_m count size_m seed clear_m", &Builder::rocks}},
    {"foliage", {"at_m size_m yaw_deg lift_m form mean_free_path_m", &Builder::foliage}},
    {"grass", {"at_m size_m yaw_deg height_m density_per_m", &Builder::grass}},
    {"deck", {"at_m size_m yaw_deg z_m thickness_m", &Builder::deck}},
    {"tree", {"at_m height_m radius_m crown_m yaw_deg form mean_free_path_m", &Builder::tree}},
    {"branch", {"from_m to_m radius_m", &Builder::branch}},
    {"beam", {"from_m to_m underside_m width_m thickness_m", &Builder::beam}},
    {"table", {"at_m size_m yaw_deg thickness_m leg_m", &Builder::table}},
    {"railing", {"from_m to_m height_m radius_m bars spacing_m", &Builder::railing}}};

}  // namespace

void parse_objects(const YAML::Node& list, const std::string& file, World& world)
{
  constexpr std::size_t kMaxParts = 200000;  // hours of work, and 100 MB
  if (!list.IsSequence())
    fail_at(list, file, "objects", "must be a list of objects, e.g. `- box: {...}`");
  std::vector<std::string> names;
  names.reserve(kKinds.size());
  for (const auto& k : kKinds) names.push_back(k.first);
  const RobotPath path(world);
  std::vector<Shape> shapes;
  for (const auto& entry : list)
  {
    const std::string name = only_key(entry, file, "objects", names);
    const Kind& kind = kKinds.at(name);
    const Fields f(
        entry[name], file, "objects." + name,
        kind.keys + std::string(" reflectivity") + kPresenceKeys);
    const Presence presence(f);
    Builder builder(world.ground_at(presence.from_s), path);
    (builder.*kind.make)(f);
    const double reflectivity = f.number_or("reflectivity", 0.5, kShare);
    for (Shape& s : builder.shapes)
    {
      s.reflectivity = reflectivity;
      s.from_s = presence.from_s;
      s.until_s = presence.until_s;
      shapes.push_back(s);
      if (name == "deck") world.decks.push_back(s);
    }
    if (shapes.size() > kMaxParts)
      fail_at(
          entry, file, "objects",
          "the parts of all objects up to this one are more than " + std::to_string(kMaxParts) +
              ": leave some out");
  }
  world.objects = ShapeTree(std::move(shapes));
}

}  // namespace talus::sim
