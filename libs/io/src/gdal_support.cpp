#include "gdal_support.h"

#include <talus/input_file.h>
#include <talus/number_text.h>

#include <cpl_error.h>
#include <gdal_frmts.h>
#include <ogrsf_frmts.h>

#include <stdexcept>

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
  auto* self = static_cast<GdalErrors*>(CPLGetErrorHandlerUserData());
  if (level >= CE_Failure && self->first_.empty()) self->first_ = message;
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

}  // namespace talus::io
