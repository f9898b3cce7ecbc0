#include <talus/sim/scanner.h>
#include <talus/sim/random.h>
#include <talus/text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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

/** The cosine and sine of a LiDAR's angles, which many rays share; of a camera, what a pixel is
 * aside for a metre ahead. */
struct Aim
{
  double along, aside;
};

std::vector<Aim> aims_of_rings(const Scanner& scanner)
{
  std::vector<Aim> rings;
  for (const double e : scanner.elevations_rad)
    rings.push_back(scanner.camera ? Aim{1, std::tan(e)} : Aim{std::cos(e), std::sin(e)});
  return rings;
}

/** A LiDAR turns clockwise seen from above and starts at the back. */
Aim aim_of_column(const Scanner& scanner, int column)
{
  if (scanner.camera)
    return {1, scanner.half_width_tan * (1 - (2.0 * column + 1) / scanner.columns)};
  const double azimuth = kPi - 2 * kPi * column / scanner.columns;
  return {std::cos(azimuth), std::sin(azimuth)};
}

void take_column(
    const Scene& scene, const Scanner& scanner, const std::vector<Aim>& rings, const Sweep& sweep,
    int column, double since_start_s, const Pose& T, Scan& out)
{
  const Aim turn = aim_of_column(scanner, column);
  for (std::size_t ring = 0; ring < rings.size(); ++ring)
  {
    const auto index = static_cast<std::uint64_t>(column) * rings.size() + ring;
    Random random(mix(sweep.seed, index));
    if (random.uniform() < scanner.dropout) continue;
    const Aim& beam = rings[ring];
    Vec3 d{beam.along * turn.along, beam.along * turn.aside, beam.aside};
    if (scanner.camera) d = normalized(d);
    const Ray ray{{T.x(), T.y(), T.z()}, rotate(T, d)};
    const auto hit =
        first_of(scene, sweep.body, ray, d, scanner.max_range_m, mix(sweep.seed ^ 0x1EAF, index));
    if (!hit) continue;
    const double sigma = scanner.noise_m +
                         (scanner.noise_per_m + scanner.noise_per_m2 * hit->range_m) * hit->range_m;
    const double range = hit->range_m + sigma * random.normal();
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

/** A ray straight ahead that meets level ground. */
struct DownRay
{
  double ground_m;  //!< from the base
  double slope;  //!< how much deeper it comes with each metre
};

std::vector<DownRay> down_rays(const Scanner& scanner, const Pose& T_base_sensor)
{
  std::vector<DownRay> rays;
  rays.reserve(scanner.elevations_rad.size());
  for (const double elevation : scanner.elevations_rad)
  {
    const Vec3 d = rotate(T_base_sensor, {std::cos(elevation), 0, std::sin(elevation)});
    const double ahead = std::hypot(d.x, d.y);
    if (d.z >= 0) continue;
    const double range_m = T_base_sensor.z() / -d.z;
    if (range_m < scanner.min_range_m || range_m > scanner.max_range_m || d.x <= 0) continue;
    rays.push_back({T_base_sensor.x() + range_m * d.x, -d.z / ahead});
  }
  return rays;
}

}  // namespace

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
    if (lower_case(s.name) == lower_case(name)) return &s;
  return nullptr;
}

Scan take_scan(const World& world, const Scanner& scanner, const Sweep& sweep)
{
  const Scene start(world, sweep.time_s);
  const Pose T_start = sweep.T_map_sensor(sweep.time_s);
  const std::vector<Aim> rings = aims_of_rings(scanner);
  const int end_column = std::min(sweep.end_column, scanner.columns);
  const std::size_t rays = rings.size() * std::max(0, end_column - sweep.first_column);
  Scan out;
  for (auto* of_points : {&out.x_m, &out.y_m, &out.z_m, &out.intensity}) of_points->reserve(rays);
  out.ring.reserve(rays);
  const double first_s = scanner.column_time_s(sweep.first_column);
  for (int column = sweep.first_column; column < end_column; ++column)
  {
    const double since_start_s = scanner.column_time_s(column) - first_s;
    if (!sweep.motion_distortion)
    {
      take_column(start, scanner, rings, sweep, column, since_start_s, T_start, out);
      continue;
    }
    const double t = sweep.time_s + since_start_s;
    take_column(
        Scene(world, t), scanner, rings, sweep, column, since_start_s, sweep.T_map_sensor(t), out);
  }
  return out;
}

double narrowest_hole_m(
    const Scanner& scanner, const Pose& T_base_sensor, double speed_mps, const Stopping& stopping)
{
  // A ray looks into a hole from where it passes the near edge, on until it meets the far side less
  // than kFound_m down: there must be a sweep on this stretch, and the first of them soon enough.
  const double a_sweep_m = speed_mps / scanner.rate_hz;
  const double needed_m = stopping.front_m + stopping.distance_m(speed_mps) + a_sweep_m;
  double min_m = std::numeric_limits<double>::infinity();
  for (const DownRay& ray : down_rays(scanner, T_base_sensor))
    if (ray.ground_m >= needed_m) min_m = std::min(min_m, kFound_m / ray.slope + a_sweep_m);
  return min_m;
}

double fastest_before_hole_mps(
    const Scanner& scanner, const Pose& T_base_sensor, double width_m, const Stopping& stopping)
{
  // A slower robot finds each hole that a faster one finds.
  int slow = 0, fast = 2001;
  while (fast - slow > 1)
  {
    const int middle = (slow + fast) / 2;
    const bool found = narrowest_hole_m(scanner, T_base_sensor, 0.01 * middle, stopping) <= width_m;
    (found ? slow : fast) = middle;
  }
  return 0.01 * slow;
}

double nearest_ground_m(const Scanner& scanner, const Pose& T_base_sensor)
{
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const DownRay& ray : down_rays(scanner, T_base_sensor))
    nearest_m = std::min(nearest_m, ray.ground_m);
  return nearest_m;
}

}  // namespace talus::sim
