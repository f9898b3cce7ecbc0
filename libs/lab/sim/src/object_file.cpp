#include <talus/sim/random.h>

#include <algorithm>
#include <functional>
#include <iomanip>
#include <map>
#include <sstream>

#include "place_shapes.h"
#include "world_parts.h"

namespace talus::sim
{
namespace
{
/** Makes the shapes of one entry after another. */
class Builder
{
 public:
  Builder(const Ground& ground, const RobotPath& path) : place_(ground, shapes), path_(path) {}
  Builder(const Builder&) = delete;
  Builder& operator=(const Builder&) = delete;

  void box(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny), size = f.numbers("size_m", 3, kPositive);
    place_.box(at[0], at[1], {size[0], size[1], size[2]}, yaw(f), lift(f));
    reflect(f, 1);
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
      place_.box(p.x, p.y, {piece_m, thickness, height}, line.yaw_rad, 0);
    }
    reflect(f, pieces);
  }

  void post(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    place_.post(
        at[0], at[1], f.number("height_m", kPositive), f.number("radius_m", kPositive), lift(f));
    reflect(f, 1);
  }

  void posts(const Fields& f)
  {
    const int count = f.whole("count", 2, 1000);
    const Line line = line_of(f);
    for (int i = 0; i < count; ++i)
    {
      const Vec3 p = line.at(static_cast<double>(i) / (count - 1));
      place_.post(p.x, p.y, f.number("height_m", kPositive), f.number("radius_m", kPositive), 0);
    }
    reflect(f, count);
  }

  void sphere(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    const double r = f.number("radius_m", kPositive), z = place_.ground_m(at[0], at[1]) + lift(f);
    shapes.push_back(make_ellipsoid({at[0], at[1], z + r}, {r, r, r}, 0));
    reflect(f, 1);
  }

  void rock(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny), size = f.numbers("size_m", 3, kPositive);
    place_.stone(at[0], at[1], {size[0], size[1], size[2]}, yaw(f));
    reflect(f, 1);
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
      place_.stone(x, y, {s, s * random.uniform(0.6, 1), s * random.uniform(0.5, 0.9)}, turn);
      ++made;
    }
    if (made < count) f.fail("area_m", "has no room for the rocks away from the robot's path");
    reflect(f, count);
  }

  void foliage(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny), size = f.numbers("size_m", 3, kPositive);
    leaves(f, at[0], at[1], {size[0], size[1], size[2]}, lift(f));
    reflect(f, 1);
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
        place_.box(x, y, {length, width, height}, turn, 0);
        shapes.back().mean_free_path_m = depth;
        shapes.back().grass = true;
      }
    reflect(f, static_cast<std::ptrdiff_t>(columns * rows));
  }

  void deck(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny), size = f.numbers("size_m", 2, kPositive);
    const double top = f.number("z_m", kAny),
                 thickness = f.number_or("thickness_m", 0.2, kPositive);
    shapes.push_back(
        make_box({at[0], at[1], top - thickness}, {size[0], size[1], thickness}, yaw(f)));
    reflect(f, 1);
  }

  void tree(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny);
    const double height = f.number("height_m", kPositive), r = f.number("radius_m", kPositive);
    const double crown = 2 * f.number("crown_m", kPositive);
    place_.post(at[0], at[1], height, r, 0);
    leaves(f, at[0], at[1], {crown, crown, 0.8 * crown}, height - 0.1 * crown);
    reflect(f, 2);
  }

  void branch(const Fields& f)
  {
    const auto a = f.numbers("from_m", 3, kAny), b = f.numbers("to_m", 3, kAny);
    const Vec3 from{a[0], a[1], a[2] + place_.ground_m(a[0], a[1])};
    const Vec3 to{b[0], b[1], b[2] + place_.ground_m(b[0], b[1])};
    if (norm(to - from) < 1e-3) f.fail("to_m", "must differ from from_m");
    shapes.push_back(make_cylinder(from, to, f.number("radius_m", kPositive)));
    reflect(f, 1);
  }

  void beam(const Fields& f)
  {
    const Line line = line_of(f);
    const Vec3 p = line.at(0.5);
    const Vec3 size{
        line.length_m, f.number("width_m", kPositive), f.number("thickness_m", kPositive)};
    place_.box(p.x, p.y, size, line.yaw_rad, f.number("underside_m", kPositive));
    reflect(f, 1);
  }

  void table(const Fields& f)
  {
    const auto at = f.numbers("at_m", 2, kAny), size = f.numbers("size_m", 3, kPositive);
    const double top = f.number_or("thickness_m", 0.03, {1e-3, size[2]});
    const double leg = f.number_or("leg_m", 0.05, kPositive), turn = yaw(f);
    place_.box(at[0], at[1], {size[0], size[1], top}, turn, size[2] - top);
    const double under = shapes.back().T_map_shape.z() - 0.5 * top;
    for (const double sx : {-0.5, 0.5})
      for (const double sy : {-0.5, 0.5})
      {
        const double dx = sx * (size[0] - leg), dy = sy * (size[1] - leg);
        const double x = at[0] + dx * std::cos(turn) - dy * std::sin(turn);
        const double y = at[1] + dx * std::sin(turn) + dy * std::cos(turn);
        const double height = std::max(1e-3, under - place_.ground_m(x, y));
        place_.box(x, y, {leg, leg, height}, turn, 0);
      }
    reflect(f, 5);
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
      place_.post(p.x, p.y, height, r, 0);
      for (int bar = 1; i > 0 && bar <= bars; ++bar)
      {
        const Vec3 before = line.at((i - 1.0) / spans);
        const Vec3 up{0, 0, height * bar / bars};
        shapes.push_back(make_cylinder(place_.on_ground(before) + up, place_.on_ground(p) + up, r));
      }
    }
    reflect(f, spans + 1 + spans * bars);
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
      place_.box(x, y, size, yaw(f), lift_m);
    else
      shapes.push_back(make_ellipsoid(
          {x, y, place_.ground_m(x, y) + lift_m + 0.5 * size.z}, size * 0.5, yaw(f)));
    shapes.back().mean_free_path_m = f.number_or("mean_free_path_m", 0.1, kPositive);
  }

  /** Sets the reflectivity of the last `count` shapes. */
  void reflect(const Fields& f, std::ptrdiff_t count)
  {
    const double value = f.number_or("reflectivity", 0.5, kShare);
    std::for_each(shapes.end() - count, shapes.end(), [&](Shape& s) { s.reflectivity = value; });
  }

  PlaceShapes place_;
  const RobotPath& path_;
};

struct Kind
{
  std::vector<std::string> keys;
  void (Builder::*make)(const Fields&);
};

const std::map<std::string, Kind>& kinds()
{
  static const std::map<std::string, Kind> all{
      {"box", {{"at_m", "size_m", "yaw_deg", "lift_m", "reflectivity"}, &Builder::box}},
      {"wall", {{"from_m", "to_m", "height_m", "thickness_m", "reflectivity"}, &Builder::wall}},
      {"post", {{"at_m", "height_m", "radius_m", "lift_m", "reflectivity"}, &Builder::post}},
      {"posts",
       {{"from_m", "to_m", "count", "height_m", "radius_m", "reflectivity"}, &Builder::posts}},
      {"sphere", {{"at_m", "radius_m", "lift_m", "reflectivity"}, &Builder::sphere}},
      {"rock", {{"at_m", "size_m", "yaw_deg", "reflectivity"}, &Builder::rock}},
      {"rocks",
       {{"area_m", "count", "size_m", "seed", "clear_m", "reflectivity"}, &Builder::rocks}},
      {"foliage",
       {{"at_m", "size_m", "yaw_deg", "lift_m", "form", "mean_free_path_m", "reflectivity"},
        &Builder::foliage}},
      {"grass",
       {{"at_m", "size_m", "yaw_deg", "height_m", "density_per_m", "reflectivity"},
        &Builder::grass}},
      {"deck",
       {{"at_m", "size_m", "yaw_deg", "z_m", "thickness_m", "reflectivity"}, &Builder::deck}},
      {"tree",
       {{"at_m", "height_m", "radius_m", "crown_m", "yaw_deg", "form", "mean_free_path_m",
         "reflectivity"},
        &Builder::tree}},
      {"branch", {{"from_m", "to_m", "radius_m", "reflectivity"}, &Builder::branch}},
      {"beam",
       {{"from_m", "to_m", "underside_m", "width_m", "thickness_m", "reflectivity"},
        &Builder::beam}},
      {"table",
       {{"at_m", "size_m", "yaw_deg", "thickness_m", "leg_m", "reflectivity"}, &Builder::table}},
      {"railing",
       {{"from_m", "to_m", "height_m", "radius_m", "bars", "spacing_m", "reflectivity"},
        &Builder::railing}}};
  return all;
}

}  // namespace

void parse_objects(const YAML::Node& list, const std::string& file, World& world)
{
  constexpr std::size_t kMaxParts = 200000;  // hours of work, and 100 MB
  if (!list.IsSequence())
    fail_at(list, file, "objects", "must be a list of objects, e.g. `- box: {...}`");
  std::vector<std::string> names;
  for (const auto& k : kinds()) names.push_back(k.first);
  const RobotPath path(world);
  std::vector<Shape> shapes;
  for (const auto& entry : list)
  {
    const std::string name = only_key(entry, file, "objects", names);
    const Kind& kind = kinds().at(name);
    const Fields f(entry[name], file, "objects." + name, with_presence(kind.keys));
    const Presence presence(f);
    Builder builder(world.ground_at(presence.from_s), path);
    (builder.*kind.make)(f);
    for (Shape& s : builder.shapes)
    {
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
