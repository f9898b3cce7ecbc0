#pragma once
#include "log_mapper.h"

#include <talus/io/geo_origin.h>

#include <optional>
#include <string>

namespace talus::app
{
/** Writes map.tif, map.png, timing.csv and summary.json into a folder. Throws std::runtime_error
 * naming the file. */
void write_results(
    const std::string& folder, const LogMapper& mapper, const std::optional<io::GeoOrigin>& origin);

/** Writes frames/frame_NNNNNN.tif and .png of the map as it is now. Throws std::runtime_error. */
void write_snapshot(
    const std::string& folder, const LogMapper& mapper, const std::optional<io::GeoOrigin>& origin);

/** A few lines for the terminal about what was done. */
std::string console_summary(const LogMapper& mapper);

/** The text of an INI file (--config) that suits the log that was read, a line a parameter, each
 * with its reason. */
std::string suggestion_ini(const LogMapper& mapper);

}  // namespace talus::app
