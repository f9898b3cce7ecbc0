#pragma once
#include <talus/import/scan_source.h>

#include <memory>
#include <string>

namespace talus::import
{
/** Scans and poses of a source in the frames of a log, whatever frames the source has them in:
 * points in that of the sensor (--clouds-in map, world coordinates), poses of the base (--poses-of
 * sensor). Tells what of it contradicts what it reads. `path` names the source in messages;
 * `mounted_by_tf`: its mountings are those of the frames of the clouds. */
std::unique_ptr<ScanSource> place_scans(
    std::unique_ptr<ScanSource> source, const std::string& path, const SourceOptions& options,
    bool mounted_by_tf);

}  // namespace talus::import
