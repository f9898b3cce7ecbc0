#pragma once
#include <iostream>
#include <mutex>
#include <set>
#include <string>

namespace talus::detail
{
/** Prints `message` to stderr, only once for each `key` in the life of the process; the message
 * itself is the key where none is given. */
inline void warn_once(const std::string& message, const std::string& key = {})
{
  static std::mutex mutex;
  static std::set<std::string> seen;
  const std::lock_guard<std::mutex> lock(mutex);
  if (seen.insert(key.empty() ? message : key).second)
    std::cerr << "[talus::CDualElevationMap] " << message << std::endl;
}

}  // namespace talus::detail
