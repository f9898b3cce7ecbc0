#include <talus/site/gps_origin.h>

#include <talus/number_text.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace talus::site
{
namespace
{
constexpr double kShortest_m = 10;  // a drive that tells the heading
constexpr double kRad = M_PI / 180;

using Vec3 = std::array<double, 3>;

/** WGS 84. */
constexpr double kRadius_m = 6378137, kFlattening = 1 / 298.257223563;
constexpr double kE2 = kFlattening * (2 - kFlattening);

Vec3 earth_centred(double latitude_deg, double longitude_deg, double altitude_m)
{
  const double lat = latitude_deg * kRad, lon = longitude_deg * kRad;
  const double n = kRadius_m / std::sqrt(1 - kE2 * std::sin(lat) * std::sin(lat));
  const double r = (n + altitude_m) * std::cos(lat);
  return {r * std::cos(lon), r * std::sin(lon), (n * (1 - kE2) + altitude_m) * std::sin(lat)};
}

/** East, north, up at a place on Earth. */
class LocalFrame
{
 public:
  LocalFrame(double latitude_deg, double longitude_deg, double altitude_m)
      : at_(earth_centred(latitude_deg, longitude_deg, altitude_m))
  {
    const double sp = std::sin(latitude_deg * kRad), cp = std::cos(latitude_deg * kRad);
    const double sl = std::sin(longitude_deg * kRad), cl = std::cos(longitude_deg * kRad);
    axes_ = {Vec3{-sl, cl, 0}, Vec3{-sp * cl, -sp * sl, cp}, Vec3{cp * cl, cp * sl, sp}};
  }

  Vec3 local(const Vec3& earth) const
  {
    Vec3 p{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) p[i] += axes_[i][k] * (earth[k] - at_[k]);
    return p;
  }
  Vec3 earth(const Vec3& p) const
  {
    Vec3 e = at_;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) e[k] += axes_[i][k] * p[i];
    return e;
  }

 private:
  Vec3 at_;
  std::array<Vec3, 3> axes_{};
};

/** Latitude and longitude [degrees]. */
std::array<double, 2> geodetic(const Vec3& earth)
{
  const double r = std::hypot(earth[0], earth[1]);
  double lat = std::atan2(earth[2], r * (1 - kE2));
  for (int i = 0; i < 6; ++i)
  {
    const double s = std::sin(lat), n = kRadius_m / std::sqrt(1 - kE2 * s * s);
    lat = std::atan2(earth[2] + kE2 * n * s, r);
  }
  return {lat / kRad, std::atan2(earth[1], earth[0]) / kRad};
}

/** How fixes lie around their middle, and the map around its. */
struct Alignment
{
  Vec3 map{}, local{};
  double heading_rad = 0, farthest_m = 0, rms_m = 0;

  Alignment(const std::vector<GpsFix>& fixes, const LocalFrame& frame)
  {
    std::vector<Vec3> places;
    places.reserve(fixes.size());
    for (const GpsFix& f : fixes)
      places.push_back(frame.local(earth_centred(f.latitude_deg, f.longitude_deg, f.altitude_m)));
    const double share = 1.0 / static_cast<double>(fixes.size());
    for (std::size_t i = 0; i < fixes.size(); ++i)
    {
      const Vec3 p{fixes[i].x_m, fixes[i].y_m, fixes[i].z_m};
      for (std::size_t k = 0; k < 3; ++k) map[k] += share * p[k], local[k] += share * places[i][k];
      farthest_m = std::max(farthest_m, std::hypot(p[0] - fixes[0].x_m, p[1] - fixes[0].y_m));
    }
    turn(fixes, places);
  }

 private:
  void turn(const std::vector<GpsFix>& fixes, const std::vector<Vec3>& places)
  {
    double along = 0, across = 0, sum2 = 0;
    for (std::size_t i = 0; i < fixes.size(); ++i)
    {
      const double x = fixes[i].x_m - map[0], y = fixes[i].y_m - map[1];
      const double east = places[i][0] - local[0], north = places[i][1] - local[1];
      along += x * east + y * north;
      across += x * north - y * east;
      sum2 += x * x + y * y + east * east + north * north;
    }
    heading_rad = std::atan2(across, along);
    const double left = sum2 - 2 * std::hypot(along, across);
    rms_m = std::sqrt(std::max(0.0, left) / static_cast<double>(fixes.size()));
  }
};
}  // namespace

std::optional<GeoOrigin> origin_from_fixes(const std::vector<GpsFix>& fixes, std::string& warning)
{
  if (fixes.empty()) return std::nullopt;
  const GpsFix& first = fixes.front();
  const LocalFrame frame(first.latitude_deg, first.longitude_deg, first.altitude_m);
  Alignment a(fixes, frame);
  constexpr double kMax_m = 5;
  if (a.farthest_m < kShortest_m)
  {
    a.heading_rad = 0;
    a.map = {first.x_m, first.y_m, first.z_m};
    a.local = {};
    warning =
        "the fixes of the log's GPS are too close to each other to tell where north is; x was "
        "taken to point east: give --origin LAT,LON,ALT,HEADING";
  }
  else if (a.rms_m > kMax_m)
    warning = "the way of the log's GPS is " + fixed_text(a.rms_m, 1) +
              " m off that of its poses (root mean square): check where the map lies on Earth, or "
              "give --origin LAT,LON,ALT,HEADING";
  const double c = std::cos(a.heading_rad), s = std::sin(a.heading_rad);
  const Vec3 origin{
      a.local[0] - c * a.map[0] + s * a.map[1], a.local[1] - s * a.map[0] - c * a.map[1], 0};
  const auto [latitude_deg, longitude_deg] = geodetic(frame.earth(origin));
  return GeoOrigin{
      latitude_deg, longitude_deg, first.altitude_m + a.local[2] - a.map[2], a.heading_rad / kRad};
}

}  // namespace talus::site
