#pragma once
#include <talus/import/scan_source.h>

#include <memory>
#include <string>

namespace talus::import
{
/** A folder of .bin, .pcd or .ply files, a scan each and all of one sensor, in the order of their
 * names (numbers in them count as numbers), or one such file. Reads what lies beside them:
 * times.txt or timestamps.txt, calib.txt, poses. Throws std::runtime_error as open_scan_source().
 */
std::unique_ptr<ScanSource> open_scan_folder(const std::string& path, const SourceOptions& options);

}  // namespace talus::import
