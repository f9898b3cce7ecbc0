#include "gdal_support.h"

#include <talus/input_file.h>
#include <talus/number_text.h>
#include <cpl_error.h>
#include <gdal_frmts.h>
#include <ogrsf_frmts.h>

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace talus::io
{
namespace
{
GDALDriver& driver(const char* name)
{
  static const bool once =
      (GDALRegister_GTiff(), GDALRegister_COG(), RegisterOGRGeoPackage(), true);
  (void)once;
  auto* found = GetGDALDriverManager()->GetDriverByName(name);
  if (!found)
    throw std::runtime_error(std::string("this GDAL was built without its driver ") + name);
  return *found;
}
/** What another program has done to the values of a band; empty: nothing. */
std::string conversion_of(GDALDataset& dataset, GDALRasterBand& band)
{
  int has_scale = 0, has_offset = 0;
  const double scale = band.GetScale(&has_scale), offset = band.GetOffset(&has_offset);
  const char* const bits = band.GetMetadataItem("NBITS", "IMAGE_STRUCTURE");
  const char* const codec = dataset.GetMetadataItem("COMPRESSION", "IMAGE_STRUCTURE");
  const std::string compression = codec ? codec : "";
  if (band.GetRasterDataType() != GDT_Float32)
    return std::string("holds ") + GDALGetDataTypeName(band.GetRasterDataType()) + ", not Float32";
  if ((has_scale && scale != 1) || (has_offset && offset != 0))
    return "has a scale or an offset (" + number_text(scale) + ", " + number_text(offset) + ")";
  if (bits) return std::string("is rounded to ") + bits + " bits";
  for (const char* const lossy : {"LERC", "JXL", "JPEG", "WEBP"})
    if (compression.find(lossy) != compression.npos)
      return "is compressed with " + compression + ", which rounds";
  return "";
}

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

GdalCacheLimit::GdalCacheLimit() : before_(GDALGetCacheMax64())
{
  constexpr std::int64_t kCacheBytes = 256LL << 20;
  if (before_ > kCacheBytes) GDALSetCacheMax64(kCacheBytes);
}
GdalCacheLimit::~GdalCacheLimit() { GDALSetCacheMax64(before_); }

GdalErrors::GdalErrors() { CPLPushErrorHandlerEx(&GdalErrors::handler, this); }
GdalErrors::~GdalErrors() { CPLPopErrorHandler(); }

void GdalErrors::handler(CPLErr level, CPLErrorNum, const char* message)
{
  constexpr std::size_t kMax = 120;  // a failed statement of SQL is told whole, before the reason
  auto* self = static_cast<GdalErrors*>(CPLGetErrorHandlerUserData());
  if (level < CE_Failure || !self->first_.empty()) return;
  self->first_ = message;
  if (self->first_.size() > kMax) self->first_.replace(0, self->first_.size() - kMax, "...");
}

void fail(const std::string& path, const char* what, const GdalErrors& errors)
{
  throw std::runtime_error(path + ": " + what + (errors.any() ? ": " + errors.text() : ""));
}

GDALDriver& geotiff_driver() { return driver("GTiff"); }
GDALDriver& cog_driver() { return driver("COG"); }
GDALDriver& geopackage_driver() { return driver("GPKG"); }

DatasetPtr open_geotiff(const std::string& path, const GdalErrors& errors)
{
  require_readable_file(path, "GeoTIFF");
  geotiff_driver();
  const char* const only_geotiff[] = {"GTiff", nullptr};
  DatasetPtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER, only_geotiff));
  if (!dataset) fail(path, "cannot read this file as a GeoTIFF", errors);
  return dataset;
}

void require_plain_floats(GDALDataset& dataset, const std::string& path)
{
  for (auto* band : dataset.GetBands())
    if (const std::string what = conversion_of(dataset, *band); !what.empty())
      throw std::runtime_error(
          path + ": its band '" + band->GetDescription() + "' " + what +
          ": another program has converted this file; give it as talus wrote it");
}

OGRSpatialReference map_frame()
{
  OGRSpatialReference frame;
  frame.SetLocalCS("talus map frame");
  frame.SetLinearUnits(SRS_UL_METER, 1.0);
  return frame;
}

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
