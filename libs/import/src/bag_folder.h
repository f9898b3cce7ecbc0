#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace talus::import
{
struct FilesOfBag
{
  std::vector<std::string> files;
  std::map<std::string, std::uint64_t> told;  //!< messages by topic; empty: nobody tells
  std::vector<std::string> remarks;  //!< what a person should know, a sentence each
};

/** Of each path what metadata.yaml names, or all .db3 and .mcap of a folder where it names none;
 * the path itself where it is a file. Each file is there once. Those without a byte are left out
 * where there are others. Throws std::runtime_error where one is missing or packed as a whole. */
FilesOfBag files_of_bags(const std::vector<std::string>& paths);

}  // namespace talus::import
