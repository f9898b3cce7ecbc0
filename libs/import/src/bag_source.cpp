#include "bag_source.h"

#include <stdexcept>

namespace talus::import
{
std::unique_ptr<ScanSource> open_bag(const std::string& path, const SourceOptions&)
{
  throw std::runtime_error(path + ": is a ROS 2 bag, which this build does not read.");
}

}  // namespace talus::import
