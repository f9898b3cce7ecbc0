#include <talus/sim/scanner.h>
#include <talus/sim/random.h>

#include <algorithm>
#include <cctype>

namespace talus::sim
{
namespace
{
std::vector<double> beams(int count, double lowest_deg, double highest_deg)
{
  std::vector<double> out(count);
  for (int i = 0; i < count; ++i)
    out[i] = radians(lowest_deg + (highest_deg - lowest_deg) * i / (count - 1));
  return out;
}

Scanner lidar(
    const char* name, const char* description, std::vector<double> elevations_rad, int columns,
    double min_range_m, double max_range_m)
{
  Scanner s;
  s.name = name;
  s.description = description;
  s.elevations_rad = std::move(elevations_rad);
  s.columns = columns;
  s.min_range_m = min_range_m;
  s.max_range_m = max_range_m;
  return s;
}

/** Forward depth camera of width x height pixels over a field of view. */
Scanner depth_camera(int width, int height, double width_deg, double height_deg)
{
  Scanner s = lidar("depth-camera", "forward, 87 x 58 degrees, 0.3 to 6 m", {}, width, 0.3, 6.0);
  s.camera = true;
  s.half_width_tan = std::tan(radians(0.5 * width_deg));
  const double half_height_tan = std::tan(radians(0.5 * height_deg));
  for (int row = 0; row < height; ++row)
    s.elevations_rad.push_back(std::atan(half_height_tan * ((2.0 * row + 1) / height - 1)));
  s.rate_hz = 15;
  s.noise_m = 0.002;
  s.noise_per_m2 = 0.002;
  return s;
}

std::string lower(std::string text)
{
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/** What a ray from the sensor meets first: the robot's own body hides what is behind it. */
std::optional<Scene::Hit> first_of(
    const Scene& scene, const std::vector<Shape>& body, const Ray& ray, const Vec3& in_sensor,
    double max_m, std::uint64_t chance)
{
  auto best = scene.cast(ray, max_m, chance);
  for (const Shape& s : body)
  {
    const auto range_m = first_hit(s, {{0, 0, 0}, in_sensor}, chance);
    if (range_m && *range_m < (best ? best->range_m : max_m))
      best = Scene::Hit{*range_m, s.reflectivity, &s};
  }
  return best;
}

void take_column(
    const Scene& scene, const Scanner& scanner, const Sweep& sweep, int column,
    double since_start_s, const Pose& T, Scan& out)
{
  const int rings = static_cast<int>(scanner.elevations_rad.size());
  for (int ring = 0; ring < rings; ++ring)
  {
    const auto index = static_cast<std::uint64_t>(column) * rings + ring;
    Random random(mix(sweep.seed, index));
    const bool lost = random.uniform() < scanner.dropout;
    const double noise = random.normal();
    if (lost) continue;
    const Vec3 d = scanner.direction(ring, column);
    const Ray ray{{T.x(), T.y(), T.z()}, rotate(T, d)};
    const auto hit =
        first_of(scene, sweep.body, ray, d, scanner.max_range_m, mix(sweep.seed ^ 0x1EAF, index));
    if (!hit) continue;
    const double sigma = scanner.noise_m +
                         (scanner.noise_per_m + scanner.noise_per_m2 * hit->range_m) * hit->range_m;
    const double range = hit->range_m + sigma * noise;
    if (range < scanner.min_range_m || range > scanner.max_range_m) continue;
    const Vec3 p = d * range;
    out.x_m.push_back(static_cast<float>(p.x));
    out.y_m.push_back(static_cast<float>(p.y));
    out.z_m.push_back(static_cast<float>(p.z));
    out.intensity.push_back(static_cast<float>(hit->reflectivity));
    out.ring.push_back(static_cast<std::uint16_t>(ring));
    if (sweep.motion_distortion) out.time_s.push_back(static_cast<float>(since_start_s));
  }
}

}  // namespace

Vec3 Scanner::direction(int ring, int column) const
{
  const double elevation = elevations_rad[ring];
  if (camera)
  {
    const double left = half_width_tan * (1 - (2.0 * column + 1) / columns);
    return normalized({1, left, std::tan(elevation)});
  }
  const double azimuth = kPi - 2 * kPi * column / columns;
  const double c = std::cos(elevation);
  return {c * std::cos(azimuth), c * std::sin(azimuth), std::sin(elevation)};
}

double Scanner::column_time_s(int column) const
{
  return camera ? 0.0 : column / (rate_hz * columns);
}

const std::vector<Scanner>& scanners()
{
  static const std::vector<Scanner> all{
      lidar(
          "RS-LiDAR-16", "16 beams, +-15 degrees, 0.4 degree steps", beams(16, -15, 15), 900, 0.2,
          150),
      lidar(
          "VLP-16", "16 beams, +-15 degrees, 0.2 degree steps", beams(16, -15, 15), 1800, 0.5, 100),
      lidar(
          "OS1-64", "64 beams, +-22.5 degrees, 1024 columns", beams(64, -22.5, 22.5), 1024, 0.3,
          120),
      lidar("OS0-128", "128 beams, +-45 degrees, 1024 columns", beams(128, -45, 45), 1024, 0.3, 50),
      depth_camera(212, 120, 87, 58)};
  return all;
}

const Scanner* find_scanner(const std::string& name)
{
  for (const Scanner& s : scanners())
    if (lower(s.name) == lower(name)) return &s;
  return nullptr;
}

Scan take_scan(const World& world, const Scanner& scanner, const Sweep& sweep)
{
  const Scene start(world, sweep.time_s);
  const Pose T_start = sweep.T_map_sensor(sweep.time_s);
  Scan out;
  const double first_s = scanner.column_time_s(sweep.first_column);
  for (int column = sweep.first_column; column < std::min(sweep.end_column, scanner.columns);
       ++column)
  {
    const double since_start_s = scanner.column_time_s(column) - first_s;
    if (!sweep.motion_distortion)
    {
      take_column(start, scanner, sweep, column, since_start_s, T_start, out);
      continue;
    }
    const double t = sweep.time_s + since_start_s;
    take_column(Scene(world, t), scanner, sweep, column, since_start_s, sweep.T_map_sensor(t), out);
  }
  return out;
}

}  // namespace talus::sim
