#include "log_name.h"

#include <filesystem>

namespace fs = std::filesystem;

namespace talus::app
{
std::string name_of_log(const std::string& log)
{
  fs::path name = fs::path(log).filename();
  if (name.empty()) name = fs::path(log).parent_path().filename();
  for (const char* ending : {".gz", ".rawlog"})
    if (name.extension() == ending) name = name.stem();
  return name.string();
}

std::string trajectory_beside(const std::string& log)
{
  return (fs::path(log).parent_path() / (name_of_log(log) + ".tum")).string();
}

}  // namespace talus::app
