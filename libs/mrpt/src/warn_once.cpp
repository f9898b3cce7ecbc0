#include "warn_once.h"

#include <iostream>
#include <mutex>
#include <set>

namespace talus::detail
{
void warn_once(const std::string& message, const std::string& key)
{
  static std::mutex mutex;
  static std::set<std::string> seen;
  const std::lock_guard<std::mutex> lock(mutex);
  if (seen.insert(key.empty() ? message : key).second)
    std::cerr << "[talus::CDualElevationMap] " << message << std::endl;
}
}  // namespace talus::detail
