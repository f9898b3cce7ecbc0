#pragma once
#include <talus/io/layer_stack.h>

#include <map>

namespace talus::io
{
/** Writes a GeoTIFF, north up, one float32 band per layer, band description = layer name, nodata
 * NaN, compressed. `metadata` becomes dataset metadata items. The file appears whole or not at all
 * (written beside, then renamed). Throws std::runtime_error naming the file and the reason. */
void write_geotiff(
    const std::string& path, const LayerStack& stack,
    const std::map<std::string, std::string>& metadata = {});

/** Reads what write_geotiff() wrote: any GeoTIFF without rotation whose bands hold float32 as they
 * are. Throws std::runtime_error, also where another program has converted the bands. */
LayerStack read_geotiff(const std::string& path);

}  // namespace talus::io
