#include "geo_reference.h"

#include "gdal_support.h"

#include <talus/number_text.h>

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace talus::io
{
namespace
{
struct Turn
{
  double c = 1, s = 0;

  explicit Turn(const std::optional<GeoOrigin>& origin)
  {
    constexpr double kPi = 3.14159265358979323846;
    const double heading_rad = origin ? origin->heading_deg * (kPi / 180) : 0;
    const auto clean = [](double v) { return std::abs(v) < 1e-12 ? 0.0 : v; };  // of 90 degrees
    c = clean(std::cos(heading_rad));
    s = clean(std::sin(heading_rad));
  }
};
}  // namespace

std::string text_of_origin(const GeoOrigin& o)
{
  return exact_number_text(o.latitude_deg) + " " + exact_number_text(o.longitude_deg) + " " +
         exact_number_text(o.altitude_m) + " " + exact_number_text(o.heading_deg);
}

std::optional<GeoOrigin> origin_from(const std::string& text)
{
  std::istringstream words(text);
  std::vector<double> n;
  for (std::string word; words >> word;)
  {
    const auto v = number_from(word);
    if (!v || !std::isfinite(*v)) return std::nullopt;
    n.push_back(*v);
  }
  if (n.size() != 4 || std::abs(n[0]) > 90 || std::abs(n[1]) > 360) return std::nullopt;
  return GeoOrigin{n[0], n[1], n[2], n[3]};
}

OGRSpatialReference crs_of(const std::optional<GeoOrigin>& origin)
{
  if (!origin) return map_frame();
  OGRSpatialReference crs;
  const bool made =
      crs.SetProjCS("talus map: metres east and north of its origin") == OGRERR_NONE &&
      crs.SetWellKnownGeogCS("WGS84") == OGRERR_NONE &&
      crs.SetTM(origin->latitude_deg, origin->longitude_deg, 1, 0, 0) == OGRERR_NONE &&
      crs.SetLinearUnits(SRS_UL_METER, 1.0) == OGRERR_NONE;
  if (!made)
    throw std::runtime_error(
        "PROJ cannot make a coordinate system around the origin; is its proj.db installed?");
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

std::array<double, 6> transform_of(
    double min_x_m, double max_y_m, double resolution_m, const std::optional<GeoOrigin>& origin)
{
  const Turn t(origin);
  return {min_x_m * t.c - max_y_m * t.s, resolution_m * t.c, resolution_m * t.s,
          min_x_m * t.s + max_y_m * t.c, resolution_m * t.s, -resolution_m * t.c};
}

void to_crs(double& x_m, double& y_m, const std::optional<GeoOrigin>& origin)
{
  const Turn t(origin);
  const double x = x_m;
  x_m = x * t.c - y_m * t.s;
  y_m = x * t.s + y_m * t.c;
}

void put_origin(GDALDataset& dataset, const std::optional<GeoOrigin>& origin)
{
  if (!origin) return;
  dataset.SetMetadataItem(kOriginItem, text_of_origin(*origin).c_str());
  if (Turn(origin).s == 0 && Turn(origin).c > 0) return;
  const std::string text =
      "north is not up: rows lie along the x axis of the map frame, which points " +
      number_text(origin->heading_deg) +
      " degrees counter-clockwise from east; gdalwarp makes a copy with north up";
  dataset.SetMetadataItem(kAxesItem, text.c_str());
}

}  // namespace talus::io
