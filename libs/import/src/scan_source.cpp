#include <talus/import/scan_source.h>

#include <filesystem>
#include <stdexcept>

#include "bag_source.h"

namespace fs = std::filesystem;

namespace talus::import
{
namespace
{
bool is_bag(const std::string& path)
{
  const auto ending = fs::path(path).extension();
  return ending == ".db3" || ending == ".mcap" || fs::exists(fs::path(path) / "metadata.yaml");
}
}  // namespace

std::unique_ptr<ScanSource> open_scan_source(const std::string& path, const SourceOptions& options)
{
  if (is_bag(path)) return open_bag(path, options);
  throw std::runtime_error(path + ": nothing that this program reads.");
}

}  // namespace talus::import
