#pragma once
#include <string>

namespace talus::io
{
/** A style of QGIS beside a GeoTIFF (SITE.qml for SITE.tif): QGIS opens it with the traversability
 * in the colours of the pictures. Throws as write_file(). */
void write_qgis_style(const std::string& path);

}  // namespace talus::io
