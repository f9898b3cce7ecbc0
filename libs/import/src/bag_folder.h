#pragma once
#include <string>
#include <vector>

namespace talus::import
{
struct FilesOfBag
{
  std::vector<std::string> files;
  std::vector<std::string> remarks;  //!< what a person should know, a sentence each
};

/** What metadata.yaml names, or all .db3 and .mcap of a folder where it names none; `path` itself
 * where it is a file. Throws std::runtime_error where one is missing or packed as a whole. */
FilesOfBag files_of_bag(const std::string& path);

}  // namespace talus::import
