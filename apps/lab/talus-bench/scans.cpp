#include "scans.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace talus::bench
{
namespace
{
constexpr double kSensorHeight_m = 0.7, kBoxEvery_m2 = 12, kLane_m = 0.8;

struct Box
{
  double min[3], max[3];
};

double uniform(std::mt19937_64& random, double low, double high)
{
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

std::vector<Box> make_boxes(double radius_m, std::mt19937_64& random)
{
  const auto count = static_cast<int>(std::min(4 * radius_m * radius_m / kBoxEvery_m2, 60.0));
  std::vector<Box> boxes;
  while (static_cast<int>(boxes.size()) < count)
  {
    const double x = uniform(random, -radius_m, radius_m), y = uniform(random, -radius_m, radius_m);
    if (x * x + y * y < 1.5) continue;
    const double w = uniform(random, 0.05, 0.6), h = uniform(random, 0.05, 1.5);
    const double z = uniform(random, 0, 1) < 0.2 ? 0.8 : 0.0;  // some hang
    boxes.push_back({{x - w, y - w, z}, {x + w, y + w, z + h}});
  }
  return boxes;
}

/** Distance to where a ray enters a box, or infinity. */
double hit(const Box& box, const double* o, const double* d)
{
  double enter = 0, leave = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; i++)
  {
    const double a = (box.min[i] - o[i]) / d[i], b = (box.max[i] - o[i]) / d[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : std::numeric_limits<double>::infinity();
}

/** Boxes on flat ground, inside a round wall around (middle_m, 0). */
struct Place
{
  const std::vector<Box>& boxes;
  double radius_m, middle_m;
};

double cast(const Place& place, const double* o, const double* d)
{
  const double from_middle = o[0] - place.middle_m;
  const double flat2 = d[0] * d[0] + d[1] * d[1], toward = from_middle * d[0] + o[1] * d[1];
  const double beyond = from_middle * from_middle + o[1] * o[1] - place.radius_m * place.radius_m;
  double range = (-toward + std::sqrt(toward * toward - flat2 * beyond)) / flat2;
  if (d[2] < 0) range = std::min(range, -o[2] / d[2]);
  for (const Box& box : place.boxes) range = std::min(range, hit(box, o, d));
  return range;
}

Scan make_scan(const Place& place, double x_m, std::size_t points, std::mt19937_64& random)
{
  Scan s;
  s.T_map_sensor.m[3] = x_m;
  s.T_map_sensor.m[11] = kSensorHeight_m;
  const double o[3] = {x_m, 0, kSensorHeight_m};
  const std::size_t beams = points <= 20000 ? 16 : points <= 70000 ? 64 : 128;
  const std::size_t azimuths = points / beams;
  for (std::size_t i = 0; i < beams * azimuths; i++)
  {
    // Column by column, as such a scanner sends them.
    const double azimuth =
        2 * M_PI * (static_cast<double>(i / beams) + 0.37) / static_cast<double>(azimuths);
    const double elevation =
        -0.6 + 0.7 * static_cast<double>(i % beams) / static_cast<double>(beams - 1);
    const double d[3] = {
        std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
        std::sin(elevation)};
    const double range = cast(place, o, d) + uniform(random, -0.01, 0.01);
    s.x_m.push_back(static_cast<float>(range * d[0]));
    s.y_m.push_back(static_cast<float>(range * d[1]));
    s.z_m.push_back(static_cast<float>(range * d[2]));
  }
  return s;
}
}  // namespace

Frame Scan::frame() const
{
  Frame f;
  f.T_map_sensor = T_map_sensor;
  f.x_m = x_m.data(), f.y_m = y_m.data(), f.z_m = z_m.data();
  f.size = x_m.size();
  return f;
}

std::vector<Scan> make_drive(std::size_t points, double radius_m, int scans, double apart_m)
{
  std::mt19937_64 random(points);
  const std::vector<Box> boxes = make_boxes(radius_m, random);
  std::vector<Scan> drive;
  drive.reserve(static_cast<std::size_t>(scans));
  for (int i = 0; i < scans; i++)
    drive.push_back(make_scan({boxes, radius_m, 0}, apart_m * i, points, random));
  return drive;
}

std::vector<Scan> make_road(std::size_t points, double radius_m, double length_m, double apart_m)
{
  std::mt19937_64 random(points);
  std::vector<Box> boxes;
  for (const Box& box : make_boxes(length_m / 2, random))
    for (const double copy_m : {-length_m, 0.0, length_m})
    {
      Box moved = box;
      moved.min[0] += copy_m, moved.max[0] += copy_m;
      if (moved.max[1] < -kLane_m || moved.min[1] > kLane_m) boxes.push_back(moved);
    }
  std::vector<Scan> road;
  double x_m = 0;
  do
  {
    road.push_back(make_scan({boxes, radius_m, x_m}, x_m, points, random));
    x_m = std::remainder(x_m + apart_m, length_m);
  } while (std::abs(x_m) > 1e-6);
  return road;
}

}  // namespace talus::bench
