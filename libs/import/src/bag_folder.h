#pragma once
#include <string>
#include <vector>

namespace talus::import
{
/** The files of a bag in their order: what metadata.yaml names, or all .db3 and .mcap of a folder
 * without; `path` itself where it is a file. Throws std::runtime_error where one is missing or
 * packed as a whole. */
std::vector<std::string> files_of_bag(const std::string& path);

}  // namespace talus::import
