#include "log_name.h"

#include <talus/io/packed_log.h>

#include <filesystem>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
std::string without_endings(const std::string& log)
{
  fs::path name = fs::path(log).filename();
  if (name.empty()) name = fs::path(log).parent_path().filename();
  name = io::without_packing(name.string());
  const bool is_log = name.extension() == ".rawlog" || name.extension() == ".simplemap";
  return (is_log ? name.stem() : name).string();
}

/** "." and ".." are folders, and what begins with a dot is hidden. */
std::string label(std::string name)
{
  name.erase(0, name.find_first_not_of('.'));
  return name.empty() ? "unnamed" : name;
}
}  // namespace

std::string name_of_log(const std::string& log) { return label(without_endings(log)); }

std::string name_of_world(const std::string& world) { return label(fs::path(world).stem()); }

std::string name_of_map(const std::string& geotiff)
{
  const fs::path file = fs::absolute(geotiff);
  return (file.parent_path().filename() / file.stem()).string();
}

std::string trajectory_beside(const std::string& log)
{
  return (fs::path(log).parent_path() / (without_endings(log) + ".tum")).string();
}

}  // namespace talus::app
