#pragma once
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <talus/io/geo_origin.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

// Where a file of a map lies: in the map frame, or on Earth.
namespace talus::io
{
struct CloseDataset
{
  void operator()(GDALDataset* d) const { GDALClose(d); }
};
using DatasetPtr = std::unique_ptr<GDALDataset, CloseDataset>;

/** Collects what GDAL reports in this thread while it lives, instead of letting it print. */
class GdalErrors
{
 public:
  GdalErrors();
  ~GdalErrors();
  GdalErrors(const GdalErrors&) = delete;
  GdalErrors& operator=(const GdalErrors&) = delete;

  bool any() const { return !first_.empty(); }
  const std::string& text() const { return first_; }

 private:
  static void CPL_STDCALL handler(CPLErr level, CPLErrorNum, const char* message);
  std::string first_;
};

/** Throws std::runtime_error: "PATH: WHAT: what GDAL reported". */
[[noreturn]] void fail(const std::string& path, const char* what, const GdalErrors& errors);

constexpr const char* kNotWritten =
    "cannot write this GeoTIFF; is the disk full? Free some space there";

/** Of plain GeoTIFFs, and of cloud optimized ones. Throw std::runtime_error where GDAL has none. */
GDALDriver& geotiff_driver();
GDALDriver& cog_driver();
/** Of files of lines and points, as the others. */
GDALDriver& geopackage_driver();

/** Opens a GeoTIFF to read it. Throws std::runtime_error that names the file. */
DatasetPtr open_geotiff(const std::string& path, const GdalErrors& errors);

/** Throws std::runtime_error that names the file and the band unless each band holds float32 as
 * they are: no other type, no scale or offset, no rounding when it was compressed. A program that
 * converts a file keeps its metadata, so that nothing else shows it. */
void require_plain_floats(GDALDataset& dataset, const std::string& path);

/** While it lives, GDAL keeps at most 256 MB of blocks in memory. Of the whole process. */
class GdalCacheLimit
{
 public:
  GdalCacheLimit();
  ~GdalCacheLimit();
  GdalCacheLimit(const GdalCacheLimit&) = delete;
  GdalCacheLimit& operator=(const GdalCacheLimit&) = delete;

 private:
  std::int64_t before_;
};

/** Metres from the origin of the map: belongs nowhere on the globe. */
OGRSpatialReference map_frame();

/// @name Items of the metadata
/// @{
constexpr const char* kOriginItem = "TALUS_ORIGIN";  //!< latitude longitude altitude heading
/** That north is not up, and what to do; none where the axes of the map point east and north. */
constexpr const char* kAxesItem = "TALUS_AXES";
/// @}

std::string text_of_origin(const GeoOrigin& origin);
/** And back. Nothing where the text is none of an origin. */
std::optional<GeoOrigin> origin_from(const std::string& text);

/** Metres east and north of the origin; of no place on Earth where there is none. Throws
 * std::runtime_error where PROJ cannot make it. */
OGRSpatialReference crs_of(const std::optional<GeoOrigin>& origin);

/** Of an image, north up in the map frame, whose upper left corner is (min_x_m, max_y_m). */
std::array<double, 6> transform_of(
    double min_x_m, double max_y_m, double resolution_m, const std::optional<GeoOrigin>& origin);

/** A place of the map frame in the system of crs_of(). */
void to_crs(double& x_m, double& y_m, const std::optional<GeoOrigin>& origin);

/** Writes the items of the metadata of the origin. */
void put_origin(GDALDataset& dataset, const std::optional<GeoOrigin>& origin);

}  // namespace talus::io
