#pragma once
#include <talus/io/geo_origin.h>

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <array>
#include <optional>
#include <string>

// Where a file of a map lies: in the map frame, or on Earth.
namespace talus::io
{
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

/** Writes the items of the metadata that tell of the origin. */
void put_origin(GDALDataset& dataset, const std::optional<GeoOrigin>& origin);

}  // namespace talus::io
