#pragma once
#include <talus/import/scan_source.h>

#include <memory>
#include <string>

namespace talus::import
{
/** A ROS 2 bag: a folder with metadata.yaml, or one of its files (.db3, .mcap). Throws
 * std::runtime_error that names the file, what is wrong and what to do; where this build lacks what
 * reads it: the package to install. */
std::unique_ptr<ScanSource> open_bag(const std::string& path, const SourceOptions& options);

}  // namespace talus::import
