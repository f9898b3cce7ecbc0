#pragma once
#include <talus/import/scan_source.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "folder_layout.h"

namespace talus::import
{
/** What the poses of a folder of scans say. */
struct FolderPoses
{
  std::string tum;  //!< a trajectory over time; else empty
  std::vector<double> times_s;  //!< of those in `tum`, where they say the times of the scans
  /** Of the sensor, one a scan; a scan may have none. Empty: all have none. */
  std::vector<std::optional<mrpt::poses::CPose3D>> T_map_sensor;
  std::size_t scans = 0;  //!< so many of the first scans are read: those with poses, by --partial
};

/** Reads `path`, which is not empty. `have_times`: something else says when the scans were taken.
 * Throws std::runtime_error that names the file, what is wrong and which option helps. */
FolderPoses read_folder_poses(
    const std::string& path, const FolderLayout& layout, const SourceOptions& options,
    bool have_times);

}  // namespace talus::import
