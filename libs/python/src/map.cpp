#include <talus/point_labels.h>
#include <talus/risk.h>

#include <algorithm>
#include <map>
#include <optional>

#include "arrays.h"

namespace talus::python
{
namespace
{
/** "resolution" is resolution_m, too. */
const ParameterInfo* find(const std::string& name)
{
  if (const auto* exact = find_parameter(name)) return exact;
  for (const auto& info : parameter_table())
  {
    const std::string full = info.name;
    const std::size_t unit = full.rfind('_');
    if (info.unit[0] && unit != std::string::npos && full.substr(0, unit) == name) return &info;
  }
  return nullptr;
}

Parameters parameters_from(const py::kwargs& kwargs)
{
  Parameters out;
  for (const auto& [key, value] : kwargs)
  {
    const std::string name = py::str(key);
    const auto* info = find(name);
    if (!info)
    {
      const std::string nearest = nearest_parameter_name(name);
      throw py::type_error(
          "Map() has no parameter '" + name + "'" +
          (nearest.empty() ? ": help(talus.Map) lists them" : "; do you mean " + nearest + "?"));
    }
    if (info->is_text() || py::isinstance<py::str>(value))
      set_parameter(out, info->name, py::str(value));
    else if (PyNumber_Check(value.ptr()))
      set_parameter(out, *info, py::float_(py::reinterpret_borrow<py::object>(value)));
    else
      throw py::value_error(name + ": must be a number, is " + std::string(py::repr(value)));
  }
  return out;
}

std::string parameters_doc()
{
  std::string text =
      "A map of the terrain around a robot; feed it scans with update(), read its layers.\n\n"
      "Map(backend='auto', threads=0, device=0, **parameters): backend 'auto', 'cpu' or 'cuda';\n"
      "threads of the CPU backend, 0: one a core. A parameter by its name, with its unit or "
      "without:\n";
  const Parameters defaults;
  for (const auto& info : parameter_table())
    text += "\n" + std::string(info.name) + " = " + parameter_text(defaults, info) +
            (info.unit[0] ? " [" + std::string(info.unit) + "]" : "") + ": " + info.description;
  return text;
}

Backend backend_from(const std::string& name)
{
  if (name == "auto") return Backend::Auto;
  if (name == "cpu") return Backend::Cpu;
  if (name == "cuda") return Backend::Cuda;
  throw py::value_error("backend: must be 'auto', 'cpu' or 'cuda', is '" + name + "'");
}

Window window_of(Map& m)
{
  return locked(m, [](const ElevationMapper& map) { return map.window(); });
}

std::shared_ptr<const std::vector<float>> layer_of(Map& m, const std::string& name)
{
  if (const auto kept = m.layers.find(name); kept != m.layers.end()) return kept->second;
  const auto frames = m.frames;
  auto values = locked(
      m,
      [&](const ElevationMapper& map)
      {
        for (int l = 0; l < kLayerCount; l++)
          if (name == layer_name(static_cast<Layer>(l)))
            return std::make_shared<const std::vector<float>>(map.layer(static_cast<Layer>(l)));
        return std::make_shared<const std::vector<float>>(map.channel(name));
      });
  if (frames == m.frames) m.layers[name] = values;  // and no other thread changed the map
  return values;
}

std::vector<std::string> names_of(const Map& m)
{
  std::vector<std::string> names;
  names.reserve(kLayerCount);
  for (int l = 0; l < kLayerCount; l++) names.emplace_back(layer_name(static_cast<Layer>(l)));
  const auto more = channel_layer_names(m.mapper.parameters().channels);
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

/** Or KeyError. */
std::string known_name(const Map& m, const std::string& given)
{
  const auto names = names_of(m);
  if (given == "ground") return layer_name(Layer::GroundElevation);
  if (std::find(names.begin(), names.end(), given) == names.end())
    throw py::key_error("'" + given + "': no layer of this map");
  return given;
}

py::array square(const Map& m, std::shared_ptr<const std::vector<float>> values)
{
  const py::ssize_t n = m.mapper.parameters().cells();
  return as_array<float>(std::move(values), {n, n});
}

/** (K,) times and (K, 4, 4) poses. */
std::vector<TimedPose> path_from(const py::object& value)
{
  std::vector<TimedPose> path;
  if (value.is_none()) return path;
  try
  {
    for (const auto& [time_s, T] : value.cast<std::vector<std::pair<double, py::object>>>())
      path.push_back({time_s, pose_from(T, "path")});
  }
  catch (const py::cast_error&)
  {
    throw py::value_error("path: must be a list of pairs of a time [s] and a pose");
  }
  return path;
}

/** All of a frame but its points. */
PointsOfFrame frame_from(
    const Map& m, std::size_t size, const py::object& T_map_sensor, const py::object& T_base_sensor)
{
  PointsOfFrame out;
  out.frame.size = size;
  out.frame.T_map_sensor = pose_from(T_map_sensor, "T_map_sensor");
  out.frame.T_base_sensor = optional_pose(T_base_sensor, "T_base_sensor");
  out.frame.stamp_s = std::isnan(m.last_s) ? 0 : m.last_s + 0.1;
  return out;
}

void add_channels(const Map& m, const py::object& values, PointsOfFrame& p)
{
  if (values.is_none()) return;
  if (!py::isinstance<py::dict>(values)) throw py::value_error("channels: must be a dict");
  const auto& channels = m.mapper.parameters().channels;
  for (const auto& [key, value] : values.cast<py::dict>())
  {
    const std::string name = py::str(key);
    const auto at = std::find_if(
        channels.begin(), channels.end(), [&](const Channel& c) { return c.name == name; });
    if (at == channels.end())
      throw py::value_error(
          "channels: '" + name + "' is none of this map's: Map(channels='" + name + ":mean')");
    p.channels.push_back(values_from(
        py::reinterpret_borrow<py::object>(value), "channels['" + name + "']", p.frame.size));
    p.frame.channels[static_cast<std::size_t>(at - channels.begin())] = p.channels.back().data();
  }
}

/** work(map, frame) with the points of a frame, which are copied at most once, to where the map
 * reads them. */
template <class Work>
auto with_points(Map& m, const Table& points, PointsOfFrame& p, const Work& work)
{
  return locked(
      m,
      [&](ElevationMapper& map)
      {
        if (points.column(0))
        {
          p.frame.x_m = points.column(0);
          p.frame.y_m = points.column(1);
          p.frame.z_m = points.column(2);
        }
        else
          p.fill(points, map.point_arrays(p.frame.size));
        return work(map, p.frame);
      });
}

FrameReport update(
    Map& m, const py::object& points, const py::object& T_map_sensor,
    const py::object& T_base_sensor, const std::optional<double>& t, const py::object& times,
    const py::object& channels, std::uint32_t sensor, const py::object& path)
{
  const Table table(points, "points", 3);
  auto p = frame_from(m, static_cast<std::size_t>(table.rows()), T_map_sensor, T_base_sensor);
  if (t) p.frame.stamp_s = *t;
  if (!std::isfinite(p.frame.stamp_s)) throw py::value_error("t: is not finite");
  p.frame.sensor = sensor;
  p.time_s = values_from(times, "times", p.frame.size);
  if (!p.time_s.empty()) p.frame.time_s = p.time_s.data();
  p.frame.path = path_from(path);
  if (p.frame.path.size() > 1 && times.is_none())
    throw py::value_error("path: needs the times of the points");
  p.channels.reserve(kMaxChannels);
  add_channels(m, channels, p);
  const auto report = with_points(
      m, table, p, [](ElevationMapper& map, const Frame& frame) { return map.update(frame); });
  m.last_s = report.stamp_s;
  m.forget_layers();
  return report;
}

py::array labels(
    Map& m, const py::object& points, const py::object& T_map_sensor,
    const py::object& T_base_sensor)
{
  const Table table(points, "points", 3);
  auto p = frame_from(m, static_cast<std::size_t>(table.rows()), T_map_sensor, T_base_sensor);
  const auto found = with_points(
      m, table, p,
      [](ElevationMapper& map, const Frame& frame) { return label_points(map, frame); });
  std::vector<std::uint8_t> out(found.size());
  std::transform(
      found.begin(), found.end(), out.begin(),
      [](PointLabel label) { return static_cast<std::uint8_t>(label); });
  return as_array(std::move(out));
}

py::array at(Map& m, const std::string& name, const py::object& xy)
{
  const Table table(xy, "xy", 2);
  const auto values = layer_of(m, known_name(m, name));
  const Window w = window_of(m);
  std::vector<float> out;
  for (py::ssize_t i = 0; i < table.rows(); i++)
  {
    const auto cell = w.index_at(table.at(i, 0), table.at(i, 1));
    out.push_back(cell ? (*values)[*cell] : std::numeric_limits<float>::quiet_NaN());
  }
  return as_array(std::move(out));
}

py::tuple extent(Map& m)
{
  const Window w = window_of(m);
  const double side_m = w.cells * w.resolution_m;
  return py::make_tuple(w.min_x_m(), w.min_x_m() + side_m, w.min_y_m(), w.min_y_m() + side_m);
}

py::tuple xy(Map& m)
{
  const Window w = window_of(m);
  std::vector<double> x, y;
  for (int i = 0; i < w.cells; i++)
  {
    x.push_back(w.min_x_m() + (i + 0.5) * w.resolution_m);
    y.push_back(w.min_y_m() + (i + 0.5) * w.resolution_m);
  }
  return py::make_tuple(as_array(std::move(x)), as_array(std::move(y)));
}

template <class Names, class Values>
py::dict dict_of(const Names& names, const Values& values)
{
  py::dict out;
  for (std::size_t i = 0; i < names.size(); i++) out[names[i]] = values[i];
  return out;
}
}  // namespace

void bind_map(py::module_& m)
{
  using namespace py::literals;
  py::class_<FrameReport>(m, "FrameReport", "What became of the points of a frame.")
      .def_readonly("stamp", &FrameReport::stamp_s, "Stamp of the frame [s].")
      .def_readonly("points_in", &FrameReport::points_in, "Number of its points.")
      .def_readonly("points_accepted", &FrameReport::points_accepted, "Those that reached the map.")
      .def_property_readonly(
          "rejected", [](const FrameReport& r) { return dict_of(kRejectNames, r.rejected); },
          "The number of the others, by reason.")
      .def_readonly(
          "leaves_floor", &FrameReport::leaves_floor, "The map starts anew: another floor.")
      .def_property_readonly(
          "stage_ms", [](const FrameReport& r) { return dict_of(kStageNames, r.stage_ms); },
          "Time of each stage [ms].")
      .def_readonly("total_ms", &FrameReport::total_ms, "Time of all of them [ms].")
      .def(
          "__repr__",
          [](const FrameReport& r)
          {
            return "<talus.FrameReport: " + std::to_string(r.points_accepted) + " of " +
                   std::to_string(r.points_in) + " points>";
          });
  py::class_<Map>(m, "Map", parameters_doc().c_str())
      .def(
          py::init(
              [](const std::string& backend, int threads, int device, const py::kwargs& parameters)
              {
                const Parameters p = parameters_from(parameters);
                const Backend b = backend_from(backend);
                const WithoutGil release;
                return std::make_unique<Map>(p, b, threads, device);
              }),
          "backend"_a = "auto", "threads"_a = 0, "device"_a = 0)
      .def(
          "update", &update, "points"_a, "T_map_sensor"_a, "T_base_sensor"_a = py::none(),
          "t"_a = py::none(), "times"_a = py::none(), "channels"_a = py::none(), "sensor"_a = 0,
          "path"_a = py::none(),
          "Puts a scan into the map.\n\n"
          "points: (N, 3+) float32 or float64, x y z in the frame of the sensor [m]; NaN is left "
          "out.\n"
          "T_map_sensor, T_base_sensor: (4, 4) or (3, 4), poses of the sensor in the map and on "
          "the robot,\n"
          "whose base is on the ground; without the latter the base is the sensor.\n"
          "t: stamp [s]; None: 0.1 s after the frame before. sensor: which of several.\n"
          "times: (N,) of each point [s], relative to t, with path: pairs of such a time and the "
          "T_map_sensor then.\n"
          "channels: {name: (N,)} values of each point, of Map(channels='name:rule').\n"
          "Returns a FrameReport. Arrays of layers that were asked for before stay as they are.")
      .def(
          "contact",
          [](Map& map, double x, double y, double z, double sigma)
          {
            locked(map, [&](ElevationMapper& e) { e.contact(x, y, z, sigma); });
            map.forget_layers();
          },
          "x"_a, "y"_a, "z"_a, "sigma"_a,
          "A foot that stands at x, y, z of the map frame, with the standard deviation sigma of z "
          "[m]: one more\npoint of the cell (eq. 5 to 7). Inside the gate the height moves by "
          "v / (v + sigma^2) of the difference,\nv its variance; beyond it a lower z becomes the "
          "ground, a higher one the top. An unknown or filled cell is\nmeasured from then on.")
      .def(
          "__getitem__",
          [](Map& map, const std::string& name)
          { return square(map, layer_of(map, known_name(map, name))); },
          "layer"_a,
          "A layer by its name ('ground' is ground_elevation): (H, W) float32, read-only, row 0 in "
          "the\nsouth, NaN: unknown. Heights [m], variance [m^2], scores [0, 1]. A snapshot, made "
          "once a\nframe: a view of the map's memory would change while another thread updates it.")
      .def("keys", &names_of, "Names of the layers.")
      .def(
          "at", &at, "layer"_a, "xy"_a,
          "Values of a layer at positions of the map frame, (N, 2) [m]: (N,) float32, NaN outside.")
      .def(
          "labels", &labels, "points"_a, "T_map_sensor"_a, "T_base_sensor"_a = py::none(),
          "What the map says of each point of a scan (see update()): (N,) uint8, an index of "
          "talus.LABELS.")
      .def(
          "risk",
          [](Map& map)
          {
            return square(
                map, std::make_shared<const std::vector<float>>(
                         locked(map, [](const ElevationMapper& e) { return talus::risk(e); })));
          },
          "The probability of each cell to be impassable: (H, W) float32, NaN: not judged.")
      .def(
          "clear",
          [](Map& map)
          {
            locked(map, [](ElevationMapper& e) { e.clear(); });
            map.forget_layers();
            map.last_s = NAN;
          },
          "Forgets all frames.")
      .def(
          "save",
          [](Map& map)
          {
            const auto state = locked(map, [](const ElevationMapper& e) { return e.save(); });
            return py::bytes(reinterpret_cast<const char*>(state.data()), state.size());
          },
          "The whole state of the map, for restore(); channels are no part of it.")
      .def(
          "restore",
          [](Map& map, const std::string& bytes)
          {
            const std::vector<std::uint8_t> state(bytes.begin(), bytes.end());
            locked(map, [&](ElevationMapper& e) { e.restore(state); });
            map.forget_layers();
          },
          "state"_a, "Sets a state that save() of such a map returned.")
      .def("xy", &xy, "Centres of the cells [m]: x (W,) and y (H,), map frame.")
      .def_property_readonly(
          "extent", &extent,
          "(min x, max x, min y, max y) [m], as imshow(origin='lower') takes it.")
      .def_property_readonly(
          "resolution", [](const Map& map) { return map.mapper.parameters().resolution_m; },
          "Side of a cell [m].")
      .def_property_readonly(
          "shape",
          [](const Map& map) {
            return py::make_tuple(map.mapper.parameters().cells(), map.mapper.parameters().cells());
          },
          "(H, W) of each layer.")
      .def_property_readonly(
          "backend", [](const Map& map) { return map.mapper.backend_name(); },
          "'cpu' or 'cuda: NAME'.");
  m.attr("LABELS") = py::tuple(
      py::cast(std::vector<std::string>(kPointLabelNames.begin(), kPointLabelNames.end())));
}

}  // namespace talus::python
