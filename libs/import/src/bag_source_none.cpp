#include "formats.h"

#include <stdexcept>

namespace talus::import
{
std::unique_ptr<ScanSource> open_bag_source(
    const std::vector<std::string>& paths, const SourceOptions&)
{
  throw std::runtime_error(
      paths.front() +
      ": is a ROS 2 bag, and this program was built without Fast-CDR, which reads its "
      "messages: install libfastcdr-dev and build again.");
}

}  // namespace talus::import
