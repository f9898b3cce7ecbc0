#pragma once
#include <talus/elevation_mapper.h>
#include "message_of.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace talus::test
{
/** The backend that this executable specifies: one executable a backend, of the same objects. */
Backend tested_backend();

/** The defaults but for some parameters, by their names. */
inline Parameters with(std::initializer_list<std::pair<const char*, double>> values)
{
  Parameters p;
  for (const auto& [name, value] : values) set_parameter(p, *find_parameter(name), value);
  return p;
}

inline bool same_bits(const std::vector<float>& a, const std::vector<float>& b)
{
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

inline void expect_same_bits(const ElevationMapper& a, const ElevationMapper& b, int frame)
{
  for (int l = 0; l < kLayerCount; l++)
    ASSERT_TRUE(same_bits(a.layer(static_cast<Layer>(l)), b.layer(static_cast<Layer>(l))))
        << kLayerTable[l].name << " differs after frame " << frame;
}

/** Reproducible numbers on every platform (splitmix64). */
class Random
{
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits()
  {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double uniform(double low, double high)
  {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

inline Pose translation(double x_m, double y_m, double z_m)
{
  Pose p;
  p.m[3] = x_m;
  p.m[7] = y_m;
  p.m[11] = z_m;
  return p;
}

/** A box that a ray can hit: closed intervals, map frame [m]. */
struct Box
{
  double min[3], max[3];
};

/** Points of one scan, kept in the sensor frame; the sensor is not rotated. */
class Scan
{
 public:
  explicit Scan(double sensor_x_m = 0, double sensor_y_m = 0, double sensor_z_m = 0.7)
      : pose_(translation(sensor_x_m, sensor_y_m, sensor_z_m))
  {
  }

  /** Adds a point given in the map frame. */
  Scan& add(double x_m, double y_m, double z_m)
  {
    x_.push_back(static_cast<float>(x_m - pose_.x()));
    y_.push_back(static_cast<float>(y_m - pose_.y()));
    z_.push_back(static_cast<float>(z_m - pose_.z()));
    return *this;
  }

  /** Adds one point in the middle of each 0.05 m cell of a rectangle; `height(x, y)` gives z in the
   * map frame. */
  template <class Height>
  Scan& add_surface(double x0, double y0, double x1, double y1, Height height)
  {
    constexpr double r = 0.05;
    for (int iy = static_cast<int>(std::lround(y0 / r)); iy < std::lround(y1 / r); iy++)
      for (int ix = static_cast<int>(std::lround(x0 / r)); ix < std::lround(x1 / r); ix++)
        add((ix + 0.5) * r, (iy + 0.5) * r, height((ix + 0.5) * r, (iy + 0.5) * r));
    return *this;
  }

  /** What a spinning scanner sees of flat ground at z = 0 and some boxes: the nearest hit of each
   * ray. */
  Scan& cast(
      const std::vector<Box>& boxes, int azimuths = 720, double lowest_rad = -0.6,
      double highest_rad = 0.1, int beams = 48)
  {
    for (int b = 0; b < beams; b++)
      for (int a = 0; a < azimuths; a++)
        cast_ray(
            boxes, 2 * M_PI * (a + 0.37) / azimuths,
            lowest_rad + (highest_rad - lowest_rad) * b / (beams - 1));
    return *this;
  }

  Frame frame(double stamp_s = 0) const
  {
    Frame f;
    f.stamp_s = stamp_s;
    f.T_map_sensor = pose_;
    f.x_m = x_.data();
    f.y_m = y_.data();
    f.z_m = z_.data();
    f.size = x_.size();
    return f;
  }

  std::vector<float> x_, y_, z_;
  Pose pose_;

  /** How far a ray from `o` along `d` goes to a box, in lengths of d; infinity: it misses. */
  static double hit(const Box& box, const double* o, const double* d)
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

 private:
  void cast_ray(const std::vector<Box>& boxes, double azimuth, double elevation)
  {
    const double d[3] = {
        std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
        std::sin(elevation)};
    const double o[3] = {pose_.x(), pose_.y(), pose_.z()};
    double nearest = d[2] < 0 ? -o[2] / d[2] : std::numeric_limits<double>::infinity();
    for (const Box& box : boxes) nearest = std::min(nearest, hit(box, o, d));
    if (nearest < 30) add(o[0] + nearest * d[0], o[1] + nearest * d[1], o[2] + nearest * d[2]);
  }
};

/** Waves as wide as the window. */
inline Scan textured(double x_m, double y_m)
{
  const auto waves = [](double u, double v) { return 0.05 * std::sin(3 * u) * std::cos(2 * v); };
  return Scan(x_m, y_m, 0.7).add_surface(x_m - 4, y_m - 4, x_m + 4, y_m + 4, waves);
}
/** What is seen of a low box on flat ground. */
inline Scan box_ahead()
{
  return Scan().cast({{{1.5, -0.5, 0}, {1.8, 0.2, 0.4}}}, 180, -0.6, 0.1, 16);
}

/** The points of a scan in another order. */
inline Scan shuffled(const Scan& s, Random& random)
{
  std::vector<std::size_t> order(s.x_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = order.size(); i > 1; i--) std::swap(order[i - 1], order[random.bits() % i]);
  Scan out = s;
  for (std::size_t i = 0; i < order.size(); i++)
  {
    out.x_[i] = s.x_[order[i]];
    out.y_[i] = s.y_[order[i]];
    out.z_[i] = s.z_[order[i]];
  }
  return out;
}

/** A map with the defaults, on the tested backend, and short ways to ask it. */
class TestMap
{
 public:
  explicit TestMap(const Parameters& p = {}, int threads = 1) : map(p, tested_backend(), threads) {}
  /** After some frames of one scan. */
  explicit TestMap(const Scan& s, const Parameters& p = {}, int frames = 1) : TestMap(p)
  {
    for (int i = 0; i < frames; i++) update(s);
  }

  FrameReport update(const Scan& s) { return map.update(s.frame()); }
  /** On a robot. */
  FrameReport update(const Scan& s, const Pose& T_base_sensor, double stamp_s = 0)
  {
    Frame f = s.frame(stamp_s);
    f.T_base_sensor = T_base_sensor;
    return map.update(f);
  }

  /** Value of a layer in the cell that holds (x, y) of the map frame. */
  float at(Layer layer, double x_m, double y_m) const
  {
    const auto i = map.window().index_at(x_m, y_m);
    return i ? map.layer(layer)[*i] : -std::numeric_limits<float>::infinity();
  }
  float ground(double x, double y) const { return at(Layer::GroundElevation, x, y); }
  float elevation(double x, double y) const { return at(Layer::Elevation, x, y); }
  float traversability(double x, double y) const { return at(Layer::Traversability, x, y); }
  /** The variance of the fused points of a cell's ground [m^2]. */
  float fused_variance(double x, double y) const
  {
    const double cell_m = map.parameters().resolution_m;
    const auto cell = [=](double at_m)
    { return static_cast<std::int64_t>(std::floor(at_m / cell_m)); };
    return map.read_cells({{cell(x), cell(y), 1, 1}})[0].ground_variance_m2;
  }
  CellState state(double x, double y) const
  {
    return static_cast<CellState>(static_cast<int>(at(Layer::State, x, y)));
  }

  ElevationMapper map;
};

inline double flat(double, double) { return 0.0; }
/** Level ground, or the top of something, at a height. */
inline auto level(double z_m)
{
  return [z_m](double, double) { return z_m; };
}

}  // namespace talus::test
