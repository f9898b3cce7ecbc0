#pragma once
#include <string>

namespace talus::io
{
/** A style of QGIS beside a GeoTIFF (SITE.qml for SITE.tif): QGIS opens it with the traversability
 * in the colours of the pictures. Throws as write_file(). */
void write_qgis_style(const std::string& path);

/** True when a file is there and holds anything but what write_qgis_style() writes: a person made
 * it or changed it, and it stays. Throws std::runtime_error when it cannot be read. */
bool is_users_qgis_style(const std::string& path);

}  // namespace talus::io
