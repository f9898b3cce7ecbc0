#pragma once
#include <talus/io/geo_origin.h>
#include <talus/io/layer_stack.h>

#include <map>
#include <optional>
#include <string>

namespace talus::io
{
/** Writes a GeoTIFF, its rows along the x axis of the map frame, the last row first: north up where
 * y points north. One float32 band per layer, band description = layer name, nodata NaN, with units
 * and statistics, compressed; traversability, ground, elevation, variance and state come first, as
 * in all files of maps. It lies on Earth where `origin` is known. `metadata` becomes dataset
 * metadata items. The file appears whole or not at all
 * (written beside, then renamed). Throws std::runtime_error naming the file and the reason. */
void write_geotiff(
    const std::string& path, const LayerStack& stack,
    const std::map<std::string, std::string>& metadata = {},
    const std::optional<GeoOrigin>& origin = std::nullopt);

/** Reads what write_geotiff() wrote, in the map frame: any GeoTIFF without another rotation whose
 * bands hold float32 as they are. `bands`: of these names only, where they are there; empty: all.
 * Throws std::runtime_error, also where another program has
 * converted the bands. */
LayerStack read_geotiff(const std::string& path, const std::vector<std::string>& bands = {});

/** The names of the bands of such a file. Throws as read_geotiff(). */
std::vector<std::string> bands_of_geotiff(const std::string& path);

/** Where the map of such a file is on Earth; nothing where it does not say. Throws as
 * read_geotiff(). */
std::optional<GeoOrigin> origin_of_geotiff(const std::string& path);

}  // namespace talus::io
