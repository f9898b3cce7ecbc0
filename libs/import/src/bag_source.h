#pragma once
#include <talus/import/scan_source.h>

#include <memory>
#include <string>
#include <vector>

namespace talus::import
{
/** ROS 2 bags as one, as open_bags() says; scans and poses in the frames that TF gives them. */
std::unique_ptr<ScanSource> open_bag_source(
    const std::vector<std::string>& paths, const SourceOptions& options);

/** A ROS 2 bag alone: a folder, its metadata.yaml, or one of its files (.db3, .mcap). */
inline std::unique_ptr<ScanSource> open_bag(const std::string& path, const SourceOptions& options)
{
  return open_bag_source({path}, options);
}

}  // namespace talus::import
