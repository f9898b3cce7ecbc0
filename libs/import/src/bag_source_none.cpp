#include <stdexcept>

#include "bag_source.h"

namespace talus::import
{
std::unique_ptr<ScanSource> open_bag(const std::string& path, const SourceOptions&)
{
  throw std::runtime_error(
      path +
      ": is a ROS 2 bag, and this program was built without Fast-CDR, which reads its "
      "messages: install libfastcdr-dev and build again.");
}

}  // namespace talus::import
