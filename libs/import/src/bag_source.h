#pragma once
#include <talus/import/scan_source.h>

#include <memory>
#include <string>

namespace talus::import
{
/** A ROS 2 bag alone: a folder, its metadata.yaml, or one of its files (.db3, .mcap). */
inline std::unique_ptr<ScanSource> open_bag(const std::string& path, const SourceOptions& options)
{
  return open_bags({path}, options);
}

}  // namespace talus::import
