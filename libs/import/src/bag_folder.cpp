#include "bag_folder.h"

#include <talus/input_file.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <tuple>

namespace fs = std::filesystem;

namespace talus::import
{
namespace
{
constexpr const char* kMetadata = "metadata.yaml";

/** The file that a line of metadata.yaml means: before Foxy its path began with the folder's name;
 * of one that was packed as a whole, what was unpacked beside. */
fs::path file_named(const fs::path& folder, const std::string& name)
{
  const fs::path named = folder / name, beside = folder / fs::path(name).filename();
  const fs::path path = fs::exists(named) ? named : beside;
  const fs::path unpacked = path.parent_path() / path.stem();
  return path.extension() == ".zstd" && fs::exists(unpacked) ? unpacked : path;
}

std::vector<std::string> names_in(const fs::path& metadata)
{
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 24;
  const auto text = read_input_file(metadata.string(), "description of a bag", kMostBytes);
  try
  {
    const auto info = YAML::Load(text)["rosbag2_bagfile_information"];
    return info["relative_file_paths"].as<std::vector<std::string>>();
  }
  catch (const YAML::Exception& e)
  {
    throw std::runtime_error(
        metadata.string() + ": names no files of a bag (" + e.what() +
        "). Let `ros2 bag reindex` write it again, or delete it.");
  }
}

/** rosbag2 counts its files without leading zeros: 2 comes before 10. */
std::vector<std::string> files_in(const fs::path& folder)
{
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
  {
    const auto ending = entry.path().extension();
    if (ending == ".db3" || ending == ".mcap" || ending == ".zstd")
      files.push_back(file_named(folder, entry.path().filename().string()).string());
  }
  std::sort(
      files.begin(), files.end(),
      [](const std::string& a, const std::string& b)
      { return std::make_tuple(a.size(), a) < std::make_tuple(b.size(), b); });
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

void require_unpacked(const fs::path& file)
{
  if (file.extension() != ".zstd") return;
  const auto name = file.filename().string(), unpacked = file.stem().string();
  throw std::runtime_error(
      file.string() +
      ": is packed as a whole (rosbag2's compression mode FILE). Unpack it beside: "
      "zstd -d " +
      name + " -o " + unpacked);
}
}  // namespace

std::vector<std::string> files_of_bag(const std::string& path)
{
  const fs::path given(path);
  const bool is_metadata = given.filename() == kMetadata;
  const fs::path folder = is_metadata ? given.parent_path() : given;
  std::vector<std::string> files;
  if (!is_metadata && !fs::is_directory(given))
    files = {path};
  else if (is_metadata || fs::exists(folder / kMetadata))
    for (const auto& name : names_in(folder / kMetadata))
      files.push_back(file_named(folder, name).string());
  else
    files = files_in(folder);
  if (files.empty()) throw std::runtime_error(path + ": holds no file of a bag (.db3 or .mcap).");
  for (const auto& file : files) require_unpacked(file);
  return files;
}

}  // namespace talus::import
