#include <talus/nav/heading_cost.h>
#include <talus/nav/height_scan.h>
#include <talus/nav/obstacles.h>
#include <talus/nav/route.h>

#include "arrays.h"

namespace talus::python
{
namespace
{
using namespace py::literals;

struct Choice
{
  const char* name;
  int value;
};

int choice_from(
    const std::string& key, const py::object& value, std::initializer_list<Choice> choices)
{
  const std::string text = py::str(value);
  std::string names;
  for (const auto& c : choices)
  {
    if (text == c.name) return c.value;
    names += std::string(names.empty() ? "'" : ", '") + c.name + "'";
  }
  throw py::value_error(key + ": must be one of " + names + ", is '" + text + "'");
}

nav::ObstacleOptions options_from(const py::kwargs& kwargs)
{
  using O = nav::ObstacleOptions;
  static const std::vector<std::pair<std::string, double O::*>> numbers{
      {"blocked_at", &O::blocked_at},
      {"risk_at", &O::risk_at},
      {"seen_within", &O::seen_within_m},
      {"body_radius", &O::body_radius_m},
      {"range", &O::range_m},
      {"spacing", &O::spacing_m},
      {"z", &O::z_m}};
  O out;
  for (const auto& [k, v] : kwargs)
  {
    const std::string key = py::str(k);
    const auto value = py::reinterpret_borrow<py::object>(v);
    const auto number =
        std::find_if(numbers.begin(), numbers.end(), [&](const auto& n) { return n.first == key; });
    if (number != numbers.end())
      out.*number->second = py::float_(value);
    else if (key == "boundary_only")
      out.boundary_only = value.cast<bool>();
    else if (key == "unseen")
      out.unseen =
          static_cast<nav::Unseen>(choice_from(key, value, {{"obstacle", 0}, {"free", 1}}));
    else if (key == "drops")
      out.drops = static_cast<nav::Drops>(
          choice_from(key, value, {{"avoid", 0}, {"slope", 1}, {"ignore", 2}}));
    else
      throw py::type_error(
          "no option '" + key +
          "': blocked_at, risk_at, seen_within, body_radius, range, spacing, z, boundary_only, "
          "unseen or drops");
  }
  return out;
}

constexpr const char* kOptions =
    "\nOptions: blocked_at, risk_at [0, 1], seen_within, body_radius, range, spacing, z [m], "
    "boundary_only,\nunseen ('obstacle', 'free'), drops ('avoid', 'slope', 'ignore'); "
    "doc/obstacles.md says what they mean.";

py::array obstacles(
    Map& m, const py::object& T_map_base, const std::vector<double>& prism_heights,
    const py::kwargs& options)
{
  const Pose T = pose_from(T_map_base, "T_map_base");
  const auto o = options_from(options);
  auto found = std::make_shared<std::vector<float>>();
  locked(
      m,
      [&](const ElevationMapper& map)
      {
        if (map.empty()) return;
        for (const auto& p :
             nav::find_obstacles(map, T, o, nav::classify_cells(map, T, o), prism_heights))
          for (const float v : {p.x_m, p.y_m, p.z_m}) found->push_back(v);
      });
  const auto n = static_cast<py::ssize_t>(found->size() / 3);
  return as_array<float>(std::move(found), {n, 3});
}

py::array heading_cost(Map& m, const py::object& poses, const nav::Footprint& robot)
{
  const Table table(poses, "poses", 3);
  std::vector<nav::HeadingCost> costs;
  locked(
      m,
      [&](const ElevationMapper& map)
      {
        for (py::ssize_t i = 0; i < table.rows(); i++)
          costs.push_back(nav::heading_cost(
              map, robot, nav::Pose2{table.at(i, 0), table.at(i, 1), table.at(i, 2)}));
      });
  return as_array(std::move(costs));
}

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

Doubles doubles_from(const py::object& value, const char* name)
{
  refuse_masked(value, name);
  auto array = Doubles::ensure(value);
  if (!array) throw py::value_error(std::string(name) + ": must be numbers");
  return array;
}

/** Poses of shape (4, 4), or several of them. */
std::vector<Pose> poses_from(const py::object& value, const char* name)
{
  const auto array = doubles_from(value, name);
  std::vector<Pose> out;
  if (array.ndim() == 2) return {pose_from(value, name)};
  if (array.ndim() != 3)
    throw py::value_error(
        std::string(name) + ": must be of shape (4, 4) or (B, 4, 4), is " + shape_text(array));
  for (const auto& pose : array)
    out.push_back(pose_from(py::reinterpret_borrow<py::object>(pose), name));
  return out;
}

py::tuple height_scan(
    Map& m, const py::object& T_map_base, const py::object& x_of, const py::object& y_of)
{
  const auto poses = poses_from(T_map_base, "T_map_base");
  const auto x = doubles_from(x_of, "x"), y = doubles_from(y_of, "y");
  std::vector<py::ssize_t> shape(x.shape(), x.shape() + x.ndim());
  if (!std::equal(shape.begin(), shape.end(), y.shape(), y.shape() + y.ndim()))
    throw py::value_error("x and y: are of shapes " + shape_text(x) + " and " + shape_text(y));
  std::vector<nav::Point2> points;
  for (py::ssize_t i = 0; i < x.size(); i++) points.push_back({x.data()[i], y.data()[i]});
  auto z = std::make_shared<std::vector<float>>();
  auto sigma = std::make_shared<std::vector<float>>();
  auto origin = std::make_shared<std::vector<std::uint8_t>>();
  locked(
      m,
      [&](const ElevationMapper& map)
      {
        for (const Pose& T : poses)
          for (const auto& h : nav::height_scan(map, T, points))
          {
            z->push_back(h.z_m);
            sigma->push_back(h.sigma_m);
            origin->push_back(static_cast<std::uint8_t>(h.origin));
          }
      });
  if (doubles_from(T_map_base, "T_map_base").ndim() == 3)
    shape.insert(shape.begin(), static_cast<py::ssize_t>(poses.size()));
  return py::make_tuple(
      as_array<float>(std::move(z), shape), as_array<float>(std::move(sigma), shape),
      as_array<std::uint8_t>(std::move(origin), shape));
}

py::array plan(
    Map& m, const py::object& T_map_base, const std::pair<double, double>& goal,
    const nav::Footprint& robot, const py::kwargs& options)
{
  const Pose T = pose_from(T_map_base, "T_map_base");
  const auto o = options_from(options);
  return as_array(locked(
      m,
      [&](const ElevationMapper& map) {
        return nav::plan(map, T, {goal.first, goal.second}, robot, o);
      }));
}

nav::Footprint footprint_from(const py::kwargs& kwargs)
{
  using F = nav::Footprint;
  static const std::vector<std::pair<std::string, double F::*>> numbers{
      {"min_x", &F::min_x_m},
      {"max_x", &F::max_x_m},
      {"min_y", &F::min_y_m},
      {"max_y", &F::max_y_m},
      {"wheel_radius", &F::wheel_radius_m},
      {"ground_clearance", &F::ground_clearance_m},
      {"max_along", &F::max_along_rad},
      {"max_across", &F::max_across_rad},
      {"max_step", &F::max_step_m}};
  F out;
  for (const auto& [k, v] : kwargs)
  {
    const std::string key = py::str(k);
    const auto number =
        std::find_if(numbers.begin(), numbers.end(), [&](const auto& n) { return n.first == key; });
    if (number != numbers.end())
      out.*number->second = py::float_(py::reinterpret_borrow<py::object>(v));
    else if (key == "wheels")
    {
      const Table wheels(
          py::module_::import("numpy").attr("array")(v, "dtype"_a = "d"), "wheels", 2);
      out.wheels.clear();
      for (py::ssize_t i = 0; i < wheels.rows(); i++)
        out.wheels.push_back({wheels.at(i, 0), wheels.at(i, 1)});
    }
    else
      throw py::type_error(
          "Footprint() has no '" + key +
          "': min_x, max_x, min_y, max_y, wheels, wheel_radius, ground_clearance, max_along, "
          "max_across or max_step");
  }
  return out;
}
}  // namespace

void bind_nav(py::module_& m)
{
  using nav::HeadingCost, nav::RoutePose;
  PYBIND11_NUMPY_DTYPE_EX(
      HeadingCost, along_rad, "along", across_rad, "across", step_m, "step", clearance_m,
      "clearance", cost, "cost");
  PYBIND11_NUMPY_DTYPE_EX(
      RoutePose, x_m, "x", y_m, "y", yaw_rad, "yaw", backwards, "backwards", narrow, "narrow",
      tilted, "tilted");
  py::class_<nav::Footprint>(
      m, "Footprint",
      "A robot in the frame of its base, x ahead, y left:\n"
      "Footprint(min_x=-0.31, max_x=0.31, min_y=-0.29, max_y=0.29, wheels=[(x, y), ...], "
      "wheel_radius=0.08,\nground_clearance=0.1, max_step=0.2) [m], max_along=0.6, "
      "max_across=0.4 [rad].")
      .def(py::init(&footprint_from));
  auto map = py::reinterpret_borrow<py::class_<Map>>(m.attr("Map"));
  map.def(
      "obstacles", &obstacles, "T_map_base"_a, "prism_heights"_a = std::vector<double>(),
      (std::string("Obstacles around a robot, in its frame seen from above: (M, 3) float32 [m].\n"
                   "prism_heights: of a robot made of prisms [m], the lowest first.") +
       kOptions)
          .c_str());
  map.def(
      "heading_cost", &heading_cost, "poses"_a, "footprint"_a = nav::Footprint(),
      "What the ground does with a robot at poses (N, 3) x, y [m], yaw [rad], float64 or float32:\n"
      "(N,) with the fields along, across [rad], step, clearance [m] and cost [0, 1], 1: "
      "impassable; NaN:\nnot known.");
  map.def(
      "height_scan", &height_scan, "T_map_base"_a, "x"_a, "y"_a,
      "Heights below points of the robot's frame seen from above (x ahead, y left [m], arrays of "
      "one shape):\nz in the map frame and its standard deviation sigma [m], float32, and their "
      "origin, uint8: 0 unknown\n(of the nearest known cell, NaN beyond 1 m), 1 measured, 2 "
      "filled, 3 presumed. Each of the shape of x,\nafter that of the poses for T_map_base of "
      "shape (B, 4, 4). T_map_base[2, 3] - z is how far below the base.");
  m.def(
      "plan", &plan, "map"_a, "T_map_base"_a, "goal"_a, "footprint"_a = nav::Footprint(),
      (std::string(
           "A route to within 0.35 m of a goal (x, y) [m] for a robot that turns on the spot: (N,) "
           "with the\nfields x, y [m], yaw [rad], backwards, narrow, tilted; empty where there is "
           "none.") +
       kOptions)
          .c_str());
}

}  // namespace talus::python
