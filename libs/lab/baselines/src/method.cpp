#include <talus/baselines/rivals.h>
#include <talus/frame_gatherer.h>
#include <talus/point_filter.h>
#include <talus/risk.h>

#include <cmath>
#include <stdexcept>

namespace talus::baselines
{
namespace
{
constexpr double kFirstStamp_s = 1700000000.0;

class TalusMethod : public Method
{
 public:
  TalusMethod(const Parameters& parameters, Backend backend) : map_(parameters, backend, 1) {}
  void update(const Frame& frame) override
  {
    gatherer_.add(frame, [this](const Frame& scan) { map_.update(scan); });
  }
  Surfaces read() override
  {
    Surfaces s(map_.window());
    s.ground_m = map_.layer(Layer::GroundElevation);
    s.elevation_m = map_.layer(Layer::Elevation);
    s.traversability = map_.layer(Layer::Traversability);
    s.variance_m2 = map_.layer(Layer::Variance);
    s.sparsity = map_.layer(Layer::Sparsity);
    const auto& state = map_.layer(Layer::State);
    for (std::size_t i = 0; i < state.size(); ++i)
    {
      s.state[i] = static_cast<std::uint8_t>(state[i]);
      if (std::isnan(s.elevation_m[i])) s.elevation_m[i] = s.ground_m[i];
    }
    return s;
  }
  std::vector<float> risk() override { return talus::risk(map_); }

 private:
  ElevationMapper map_;
  FrameGatherer gatherer_;
};

}  // namespace

Surfaces::Surfaces(const Window& w) : window(w)
{
  const auto n = static_cast<std::size_t>(w.cells) * static_cast<std::size_t>(w.cells);
  for (auto* layer : {&elevation_m, &ground_m, &traversability}) layer->assign(n, NAN);
  state.assign(n, static_cast<std::uint8_t>(CellState::Unknown));
}

const std::vector<MethodInfo>& method_list()
{
  static const std::vector<MethodInfo> list{
      {"talus", "two surfaces, cleanup, filling (ElevationMapper)",
       [](const Parameters& p, Backend backend) -> std::unique_ptr<Method>
       { return std::make_unique<TalusMethod>(p, backend); }},
      {"paper", "the paper's method as printed: eq. 1 to 14, its fill, cleanup and hanging rule",
       make_paper},
      {"octomap", "mrpt::maps::COctoMap, its columns read out with the same clearance",
       [](const Parameters& p, Backend) -> std::unique_ptr<Method>
       { return std::make_unique<OctoMapMethod>(p); }},
      {"heightgrid", "mrpt::maps::CHeightGridMap2D, the mean height of a cell", make_heightgrid},
      {"highest", "highest-point elevation map with Kalman fusion, 7 x 7 window features",
       make_highest},
      {"cucpp", "the same with cleanup in every frame, judged half by slope, half by roughness",
       make_cucpp},
      {"cupy", "one surface, drift compensation, min filter and inpainting, window features",
       make_cupy}};
  return list;
}

std::unique_ptr<Method> make_method(
    const std::string& name, const Parameters& parameters, Backend backend)
{
  for (const MethodInfo& m : method_list())
    if (name == m.name) return m.make(parameters, backend);
  std::string known;
  for (const auto& m : method_list()) known += (known.empty() ? "" : ", ") + std::string(m.name);
  throw std::invalid_argument("unknown method '" + name + "'; known: " + known);
}

Window window_around(const Parameters& parameters, const Pose& T_map_base)
{
  const int n = parameters.cells();
  const auto first = [&](double center_m)
  { return static_cast<std::int64_t>(std::floor(center_m / parameters.resolution_m)) - n / 2; };
  return {n, parameters.resolution_m, first(T_map_base.x()), first(T_map_base.y())};
}

std::vector<MapPoint> accepted_points(const Frame& frame, const Parameters& p)
{
  std::vector<MapPoint> points;
  points.reserve(frame.size);
  const PointFilter filter(p, frame.T_map_sensor, frame.T_base_sensor);
  const auto& m = frame.T_map_sensor.m;
  for (std::size_t i = 0; i < frame.size; ++i)
  {
    const float x = frame.x_m[i], y = frame.y_m[i], z = frame.z_m[i];
    if (!filter.accepts(x, y, z)) continue;
    const auto row = [&](std::size_t r)
    { return static_cast<float>(m[r] * x + m[r + 1] * y + m[r + 2] * z + m[r + 3]); };
    points.push_back({row(0), row(4), row(8), std::sqrt(x * x + y * y + z * z)});
  }
  return points;
}

std::vector<float> lowest_points(const std::vector<MapPoint>& points, const Window& window)
{
  std::vector<float> lowest(static_cast<std::size_t>(window.cells) * window.cells, NAN);
  for (const MapPoint& p : points)
    if (const int k = cell_index(window, p.x_m, p.y_m); k >= 0)
      lowest[k] = std::fmin(lowest[k], p.z_m);
  return lowest;
}

int cell_index(const Window& w, double x_m, double y_m)
{
  const auto i = w.index_at(x_m, y_m);
  return i ? static_cast<int>(*i) : -1;
}

Middle middle_of_cell(const Window& w, std::size_t k)
{
  const auto n = static_cast<std::size_t>(w.cells);
  return {
      w.min_x_m() + (static_cast<double>(k % n) + 0.5) * w.resolution_m,
      w.min_y_m() + (static_cast<double>(k / n) + 0.5) * w.resolution_m};
}

Frame ScanFrame::view() const
{
  Frame f;
  f.stamp_s = stamp_s;
  f.T_map_sensor = T_map_sensor;
  f.T_base_sensor = T_base_sensor;
  f.sensor = sensor;
  f.x_m = x_m.data();
  f.y_m = y_m.data();
  f.z_m = z_m.data();
  f.size = x_m.size();
  return f;
}

void add_sensor(Sequence& sequence, const std::string& name)
{
  const std::string all = " + " + sequence.sensor + " + ";
  if (all.find(" + " + name + " + ") != std::string::npos) return;
  sequence.sensor += (sequence.sensor.empty() ? "" : " + ") + name;
}

Sequence simulate(
    const sim::World& world, const sim::Drive& drive,
    const std::function<void(int done, int total)>& progress)
{
  Sequence sequence;
  sequence.name = world.name;
  for (std::size_t i = 0; i < world.sensors.size(); ++i)
    add_sensor(sequence, drive.scanner(i).name);
  for (int i = 0; i < drive.frames(); ++i)
  {
    sim::Scan scan = drive.scan(i);
    ScanFrame f;
    f.time_s = drive.time_s(i);
    f.stamp_s = kFirstStamp_s + f.time_s;
    f.T_base_sensor = drive.T_base_sensor(i);
    f.sensor = static_cast<std::uint32_t>(drive.sensor(i));
    f.T_map_sensor = sim::compose(drive.T_map_base_noisy(i), *f.T_base_sensor);
    f.T_true = sim::compose(drive.T_map_base(i), *f.T_base_sensor);
    f.x_m = std::move(scan.x_m);
    f.y_m = std::move(scan.y_m);
    f.z_m = std::move(scan.z_m);
    sequence.frames.push_back(std::move(f));
    if (progress) progress(i + 1, drive.frames());
  }
  return sequence;
}

}  // namespace talus::baselines
