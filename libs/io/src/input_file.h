#pragma once
#include <string>

namespace talus::io
{
/** Checks that `path` is a regular file that can be read and is not empty. `kind` is a word for
 * messages, e.g. "rawlog". Throws std::runtime_error that names the file, what is wrong and what to
 * do. */
void require_readable_file(const std::string& path, const std::string& kind);

}  // namespace talus::io
