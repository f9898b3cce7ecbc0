#pragma once
#include <string>

namespace talus::app
{
/** What `--version` says, in one line: "talus-map 0.1.0 (commit ea309eb, backends cpu and cuda)".
 */
std::string version_line(const std::string& command);

}  // namespace talus::app
