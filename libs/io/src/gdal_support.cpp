#include "gdal_support.h"

#include <talus/input_file.h>

#include <cpl_error.h>
#include <gdal_frmts.h>

#include <stdexcept>

namespace talus::io
{
namespace
{
GDALDriver& driver(const char* name)
{
  static const bool once = (GDALRegister_GTiff(), GDALRegister_COG(), true);
  (void)once;
  auto* found = GetGDALDriverManager()->GetDriverByName(name);
  if (!found)
    throw std::runtime_error(std::string("this GDAL was built without its driver ") + name);
  return *found;
}
}  // namespace

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

DatasetPtr open_geotiff(const std::string& path, const GdalErrors& errors)
{
  require_readable_file(path, "GeoTIFF");
  geotiff_driver();
  const char* const only_geotiff[] = {"GTiff", nullptr};
  DatasetPtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER, only_geotiff));
  if (!dataset) fail(path, "cannot read this file as a GeoTIFF", errors);
  return dataset;
}

OGRSpatialReference map_frame()
{
  OGRSpatialReference frame;
  frame.SetLocalCS("talus map frame");
  frame.SetLinearUnits(SRS_UL_METER, 1.0);
  return frame;
}

}  // namespace talus::io
