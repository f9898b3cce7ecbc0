#include <talus/import/scan_source.h>
#include <talus/input_file.h>
#include <talus/io/foreign_scans.h>

#include <filesystem>
#include <stdexcept>

#include "bag_source.h"
#include "placed_scans.h"
#include "scan_folder.h"

namespace talus::import
{
std::unique_ptr<ScanSource> open_bags(
    const std::vector<std::string>& paths, const SourceOptions& options)
{
  if (!options.fields.empty())
    throw std::runtime_error(
        paths.front() + ": names its fields itself: leave out --fields, which is for .bin files.");
  return place_scans(open_bag_source(paths, options), paths.front(), options, true);
}

std::unique_ptr<ScanSource> open_scan_source(const std::string& path, const SourceOptions& options)
{
  using io::ForeignScans;
  const bool is_folder = std::filesystem::is_directory(path);
  if (!is_folder) require_readable_file(path, "scan, bag or folder of scans");
  const ForeignScans kind = io::kind_of_scans(path);
  if (kind == ForeignScans::Ros2Bag) return open_bags({path}, options);
  if (kind == ForeignScans::Ros1Bag || kind == ForeignScans::Las)
    throw std::runtime_error(path + ": " + io::how_to_import(path, kind));
  if (kind != ForeignScans::None || is_folder)
    return place_scans(open_scan_folder(path, options), path, options, false);
  throw std::runtime_error(
      path +
      ": is no .bin, .pcd or .ply scan and no bag. A rawlog needs no import: talus-map reads it.");
}

}  // namespace talus::import
