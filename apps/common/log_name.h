#pragma once
#include <string>

namespace talus::app
{
/** The file name of a log without folder, `.gz` and `.rawlog`. */
std::string name_of_log(const std::string& log);

/** NAME.tum beside NAME.rawlog, whether there is such a file or not. */
std::string trajectory_beside(const std::string& log);

}  // namespace talus::app
