#include <talus/site/gps_origin.h>

#include <talus/number_text.h>

#include <gdal_support.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace talus::site
{
namespace
{
constexpr double kShortest_m = 10;  // a drive that determines the heading
constexpr double kDegrees = 180 / M_PI;

using Vec3 = std::array<double, 3>;

/** Metres east and north of a place on Earth, and degrees. */
class LocalFrame
{
 public:
  LocalFrame(double latitude_deg, double longitude_deg)
      : local_(io::crs_of(GeoOrigin{latitude_deg, longitude_deg, 0, 0}))
  {
    earth_.CopyGeogCSFrom(&local_);
    earth_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    to_local_.reset(OGRCreateCoordinateTransformation(&earth_, &local_));
    to_earth_.reset(OGRCreateCoordinateTransformation(&local_, &earth_));
    if (!to_local_ || !to_earth_)
      throw std::runtime_error("PROJ cannot place the fixes of the log's GPS in a plane");
  }

  Vec3 local(double latitude_deg, double longitude_deg, double altitude_m) const
  {
    to_local_->Transform(1, &longitude_deg, &latitude_deg);
    return {longitude_deg, latitude_deg, altitude_m};
  }
  /** Latitude and longitude [degrees]. */
  std::array<double, 2> earth(double east_m, double north_m) const
  {
    to_earth_->Transform(1, &east_m, &north_m);
    return {north_m, east_m};
  }

 private:
  OGRSpatialReference local_, earth_;
  std::unique_ptr<OGRCoordinateTransformation> to_local_, to_earth_;
};

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
      places.push_back(frame.local(f.latitude_deg, f.longitude_deg, f.altitude_m));
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
  const LocalFrame frame(first.latitude_deg, first.longitude_deg);
  Alignment a(fixes, frame);
  constexpr double kMax_m = 5;
  if (a.farthest_m < kShortest_m)
  {
    a.heading_rad = 0;
    a.map = {first.x_m, first.y_m, first.z_m};
    a.local = {0, 0, first.altitude_m};
    warning =
        "the fixes of the log's GPS are too close to each other to find north; x was "
        "taken to point east: give --origin LAT,LON,ALT,HEADING";
  }
  else if (a.rms_m > kMax_m)
    warning = "the way of the log's GPS is " + fixed_text(a.rms_m, 1) +
              " m off that of its poses (root mean square): check where the map lies on Earth, or "
              "give --origin LAT,LON,ALT,HEADING";
  const double c = std::cos(a.heading_rad), s = std::sin(a.heading_rad);
  const auto [latitude_deg, longitude_deg] = frame.earth(
      a.local[0] - c * a.map[0] + s * a.map[1], a.local[1] - s * a.map[0] - c * a.map[1]);
  return GeoOrigin{latitude_deg, longitude_deg, a.local[2] - a.map[2], a.heading_rad * kDegrees};
}

}  // namespace talus::site
