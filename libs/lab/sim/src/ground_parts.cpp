#include <talus/sim/ground.h>
#include <talus/sim/random.h>

#include <algorithm>
#include <limits>

namespace talus::sim
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Plane : public GroundPart
{
 public:
  Plane(double z_m, double slope_x, double slope_y) : z_(z_m), sx_(slope_x), sy_(slope_y) {}
  double height_m(double x, double y) const override { return z_ + sx_ * x + sy_ * y; }
  Curvature bounds() const override
  {
    const bool tilted = sx_ != 0 || sy_ != 0;
    return {0, tilted ? -kInfinity : z_, tilted ? kInfinity : z_};
  }

 private:
  double z_, sx_, sy_;
};

class Strip : public GroundPart
{
 public:
  Strip(double x, double y, double yaw, double width, std::vector<Knot> profile)
      : x_(x),
        y_(y),
        cos_(std::cos(yaw)),
        sin_(std::sin(yaw)),
        half_width_(0.5 * width),
        knots_(std::move(profile))
  {
  }

  double height_m(double x, double y) const override
  {
    const double dx = x - x_, dy = y - y_;
    if (std::abs(cos_ * dy - sin_ * dx) > half_width_) return 0;
    const double u = cos_ * dx + sin_ * dy;
    if (u < knots_.front().u_m) return knots_.front().height_m;
    if (u >= knots_.back().u_m) return knots_.back().height_m;
    std::size_t i = knots_.size() - 2;
    while (knots_[i].u_m > u) --i;
    const Knot &a = knots_[i], &b = knots_[i + 1];
    return a.height_m + (b.height_m - a.height_m) * (u - a.u_m) / (b.u_m - a.u_m);
  }

  void breaks(const Ray& ray, std::vector<double>& out) const override
  {
    const Vec3 &o = ray.origin_m, &d = ray.direction;
    const double u0 = cos_ * (o.x - x_) + sin_ * (o.y - y_), du = cos_ * d.x + sin_ * d.y;
    const double v0 = cos_ * (o.y - y_) - sin_ * (o.x - x_), dv = cos_ * d.y - sin_ * d.x;
    if (du != 0)
      for (const Knot& k : knots_) out.push_back((k.u_m - u0) / du);
    if (dv == 0 || half_width_ == kInfinity) return;
    out.push_back((half_width_ - v0) / dv);
    out.push_back((-half_width_ - v0) / dv);
  }

  Curvature bounds() const override
  {
    Curvature b;
    for (const Knot& k : knots_)
      b = {0, std::min(b.min_m, k.height_m), std::max(b.max_m, k.height_m)};
    return b;
  }

 private:
  double x_, y_, cos_, sin_, half_width_;
  std::vector<Knot> knots_;
};

class Sine : public GroundPart
{
 public:
  Sine(double amplitude, double wavelength, double yaw, double phase)
      : amplitude_(amplitude),
        kx_(2 * kPi / wavelength * std::cos(yaw)),
        ky_(2 * kPi / wavelength * std::sin(yaw)),
        phase_(phase)
  {
  }
  double height_m(double x, double y) const override
  {
    return amplitude_ * std::sin(kx_ * x + ky_ * y + phase_);
  }
  bool curved() const override { return true; }
  Curvature bounds() const override
  {
    const double a = std::abs(amplitude_);
    return {a * std::hypot(kx_, ky_), -a, a};
  }

 private:
  double amplitude_, kx_, ky_, phase_;
};

class Mound : public GroundPart
{
 public:
  Mound(double x, double y, double radius, double height)
      : x_(x), y_(y), radius_(radius), height_(height)
  {
  }
  double height_m(double x, double y) const override
  {
    const double dx = x - x_, dy = y - y_, r2 = dx * dx + dy * dy;
    if (r2 >= radius_ * radius_) return 0;
    return 0.5 * height_ * (1 + std::cos(kPi * std::sqrt(r2) / radius_));
  }
  void breaks(const Ray& ray, std::vector<double>& out) const override
  {
    const Vec3& d = ray.direction;
    const double ox = ray.origin_m.x - x_, oy = ray.origin_m.y - y_;
    const double a = d.x * d.x + d.y * d.y, b = ox * d.x + oy * d.y;
    const double disc = b * b - a * (ox * ox + oy * oy - radius_ * radius_);
    if (a == 0 || disc <= 0) return;
    out.push_back((-b - std::sqrt(disc)) / a);
    out.push_back((-b + std::sqrt(disc)) / a);
  }
  bool curved() const override { return true; }
  Curvature curvature(double x, double y) const override
  {
    const double dx = x - x_, dy = y - y_;
    return dx * dx + dy * dy < radius_ * radius_ ? bounds() : Curvature{};
  }
  Curvature bounds() const override
  {
    return {
        std::abs(height_) * kPi / (2 * radius_), std::min(0.0, height_), std::max(0.0, height_)};
  }

 private:
  double x_, y_, radius_, height_;
};

class Roughness : public GroundPart
{
 public:
  Roughness(double amplitude, double wavelength, int octaves, std::uint64_t seed)
      : wavelength_(wavelength), octaves_(octaves), seed_(seed)
  {
    double sum = 0;
    for (int i = 0; i < octaves; ++i) sum += std::ldexp(1.0, -i);
    first_amplitude_ = amplitude / sum;
    bounds_.min_m = -amplitude;
    bounds_.max_m = amplitude;
    // Each octave: lattice heights differ by up to 2a, and 15/8 is the steepest of the blend;
    // halving amplitude and wavelength together keeps the slope.
    bounds_.max_slope = octaves * 2 * first_amplitude_ * 1.875 / wavelength;
  }

  double height_m(double x, double y) const override
  {
    double h = 0, amplitude = first_amplitude_, scale = 1 / wavelength_;
    for (int i = 0; i < octaves_; ++i, amplitude *= 0.5, scale *= 2)
      h += amplitude * noise(x * scale, y * scale, seed_ + static_cast<std::uint64_t>(i));
    return h;
  }
  bool curved() const override { return true; }
  Curvature bounds() const override { return bounds_; }

 private:
  static double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

  static double lattice(std::int64_t ix, std::int64_t iy, std::uint64_t seed)
  {
    const auto key = static_cast<std::uint64_t>(ix) * 0x9E3779B97F4A7C15ull +
                     static_cast<std::uint64_t>(iy) * 0xC2B2AE3D27D4EB4Full;
    return 2 * uniform(mix(key ^ (seed * 0xD6E8FEB86659FD93ull))) - 1;
  }

  static double noise(double x, double y, std::uint64_t seed)
  {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
    const double wx = fade(x - fx), wy = fade(y - fy);
    const double south = lattice(ix, iy, seed) * (1 - wx) + lattice(ix + 1, iy, seed) * wx;
    const double north = lattice(ix, iy + 1, seed) * (1 - wx) + lattice(ix + 1, iy + 1, seed) * wx;
    return south * (1 - wy) + north * wy;
  }

  double wavelength_, first_amplitude_ = 0;
  int octaves_;
  std::uint64_t seed_;
  Curvature bounds_;
};

}  // namespace

GroundPartPtr make_plane(double z_m, double slope_x, double slope_y)
{
  return std::make_shared<Plane>(z_m, slope_x, slope_y);
}
GroundPartPtr make_strip(
    double x_m, double y_m, double yaw_rad, double width_m, std::vector<Knot> profile)
{
  return std::make_shared<Strip>(x_m, y_m, yaw_rad, width_m, std::move(profile));
}
GroundPartPtr make_sine(double amplitude_m, double wavelength_m, double yaw_rad, double phase_rad)
{
  return std::make_shared<Sine>(amplitude_m, wavelength_m, yaw_rad, phase_rad);
}
GroundPartPtr make_mound(double x_m, double y_m, double radius_m, double height_m)
{
  return std::make_shared<Mound>(x_m, y_m, radius_m, height_m);
}
GroundPartPtr make_roughness(
    double amplitude_m, double wavelength_m, int octaves, std::uint64_t seed)
{
  return std::make_shared<Roughness>(amplitude_m, wavelength_m, octaves, seed);
}

}  // namespace talus::sim
