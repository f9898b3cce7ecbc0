#pragma once
#include <string>

namespace talus::detail
{
/** Prints `message` to stderr, only once for each `key` in the life of the process; the message
 * itself is the key where none is given. */
void warn_once(const std::string& message, const std::string& key = {});
}  // namespace talus::detail
