#include <talus/io/foreign_scans.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::io
{
namespace
{
std::string ending_of(const fs::path& path)
{
  std::string ending = path.extension().string();
  std::transform(
      ending.begin(), ending.end(), ending.begin(),
      [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

constexpr const char* kDescriptionOfBag = "metadata.yaml";

struct Mark
{
  std::string_view bytes;
  ForeignScans kind;
};
constexpr Mark kMarks[] = {
    {"# .PCD", ForeignScans::Pcd},
    {"VERSION .7\n", ForeignScans::Pcd},
    {"VERSION 0.7\n", ForeignScans::Pcd},
    {"ply\n", ForeignScans::Ply},
    {"ply\r", ForeignScans::Ply},
    {"LASF", ForeignScans::Las},
    {"#ROSBAG V2", ForeignScans::Ros1Bag},
    {"SQLite format 3", ForeignScans::Ros2Bag},
    {"\x89MCAP0\r\n", ForeignScans::Ros2Bag}};

struct Ending
{
  std::string_view text;
  ForeignScans kind;
};
constexpr Ending kEndings[] = {{".bin", ForeignScans::Bin},     {".pcd", ForeignScans::Pcd},
                               {".ply", ForeignScans::Ply},     {".las", ForeignScans::Las},
                               {".laz", ForeignScans::Las},     {".bag", ForeignScans::Ros1Bag},
                               {".db3", ForeignScans::Ros2Bag}, {".mcap", ForeignScans::Ros2Bag}};

ForeignScans kind_of_file(const std::string& path)
{
  if (fs::path(path).filename() == kDescriptionOfBag) return ForeignScans::Ros2Bag;
  std::array<char, 16> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  const std::string_view begin(head.data(), static_cast<std::size_t>(file.gcount()));
  for (const Mark& mark : kMarks)
    if (begin.substr(0, mark.bytes.size()) == mark.bytes) return mark.kind;
  return kind_by_ending(path);
}

/** Whether one of the files of a folder that are not hidden has such an ending. */
template <class Wanted>
bool holds(const fs::path& folder, const Wanted& is_wanted)
{
  std::error_code error, no_file;  // a link to itself is no file, and no error of the folder
  for (fs::directory_iterator i(folder, error), end; !error && i != end; i.increment(error))
    if (i->path().filename().string()[0] != '.' && is_wanted(i->path()) &&
        i->is_regular_file(no_file))
      return true;
  return false;
}

bool has_scans(const fs::path& folder)
{
  return holds(
      folder,
      [](const fs::path& file)
      {
        const ForeignScans kind = kind_by_ending(file.string());
        return kind >= ForeignScans::Bin && kind <= ForeignScans::Las;
      });
}

/** Also those that rosbag2 packed as a whole. */
bool has_bag_files(const fs::path& folder)
{
  return holds(
      folder,
      [](const fs::path& file)
      {
        const fs::path unpacked = ending_of(file) == ".zstd" ? file.stem() : file;
        return kind_by_ending(unpacked.string()) == ForeignScans::Ros2Bag;
      });
}
}  // namespace

ForeignScans kind_by_ending(const std::string& path)
{
  const std::string ending = ending_of(path);
  for (const Ending& e : kEndings)
    if (e.text == ending) return e.kind;
  return ForeignScans::None;
}

std::string folder_with_scans(const std::string& path)
{
  const fs::path folder(path);
  for (const fs::path& inner :
       {fs::path(), fs::path("velodyne"), fs::path("velodyne_points") / "data", fs::path("data")})
    if (const fs::path candidate = inner.empty() ? folder : folder / inner; has_scans(candidate))
      return candidate.string();
  return "";
}

ForeignScans kind_of_scans(const std::string& path)
{
  std::error_code error;
  const auto status = fs::status(path, error);
  if (fs::is_directory(status))
  {
    // A recorder that was killed leaves no metadata.yaml.
    if (fs::exists(fs::path(path) / kDescriptionOfBag, error) ||
        (has_bag_files(path) && !has_scans(path)))
      return ForeignScans::Ros2Bag;
    return folder_with_scans(path).empty() ? ForeignScans::None : ForeignScans::Folder;
  }
  return fs::is_regular_file(status) ? kind_of_file(path) : ForeignScans::None;
}

std::string how_to_import(const std::string& path, ForeignScans kind)
{
  const std::string command = "'talus-import " + path + " --output LOG.rawlog' makes a log of ";
  switch (kind)
  {
    case ForeignScans::Folder:
      return "holds scans of another program. " + command + "them.";
    case ForeignScans::Bin:
    case ForeignScans::Pcd:
    case ForeignScans::Ply:
      return "is a scan of another program. " + command + "it, or of its whole folder.";
    case ForeignScans::Ros2Bag:
      return "is a ROS 2 bag. " + command + "it.";
    case ForeignScans::Ros1Bag:
      return "is a ROS 1 bag. MRPT's 'rosbag2rawlog " + path +
             " --config bag.yml --frame base_link --output LOG.rawlog' makes a log of it; "
             "doc/import_bags.md has a bag.yml.";
    case ForeignScans::Las:
      return "is a LAS or LAZ file, which no library of Debian's reads. "
             "'pdal translate FILE.laz FILE.ply' (pdal.io) makes a .ply of it, which "
             "talus-import reads.";
    case ForeignScans::None:
      break;
  }
  return "";
}

}  // namespace talus::io
