#pragma once
#include <talus/import/scan_source.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "point_fields.h"

namespace talus::import
{
/** No scan has more bytes: a larger file is a map, or no scan at all. */
constexpr std::uint64_t kLargestScan_bytes = std::uint64_t{1} << 30;

// Each reads one file of a scan. Throws std::runtime_error that names the file, the line or byte,
// what is wrong and what to do. Takes no more memory than some times the bytes of the file (a
// compressed one: of what it unpacks to, which kLargestScan_bytes bounds).

/** Floats without a header. ScanFile::fields has the names in the order of a point; empty: those
 * of KITTI (x, y, z, reflectance), or of nuScenes (x, y, z, intensity, ring) for its `.pcd.bin`.
 * Refused where the numbers show that a point has another count of them. */
void read_bin(const std::string& path, ScanFile& out);

/** The Point Cloud Library's: ascii, binary and binary_compressed, version 0.6 and 0.7. */
void read_pcd(const std::string& path, ScanFile& out);

/** The vertices of a PLY: ascii, and binary of either byte order. */
void read_ply(const std::string& path, ScanFile& out);

/** A folder of files, a scan each and all of one sensor, in the order of their names (numbers in
 * them count as numbers), or one such file. Reads what lies beside them: times.txt or
 * timestamps.txt, calib.txt, poses. Throws std::runtime_error as open_scan_source(). */
std::unique_ptr<ScanSource> open_scan_folder(const Input& input, const SourceOptions& options);

/** ROS 2 bags as one: folders, their metadata.yaml, or their files (.db3, .mcap); scans and poses
 * in the frames that TF gives them. */
std::unique_ptr<ScanSource> open_bag_source(
    const std::vector<std::string>& paths, const SourceOptions& options);

/** What an input is known by, and what becomes of it. */
struct Format
{
  std::vector<std::string_view> endings;  //!< of its files, in small letters
  std::vector<std::string_view> marks;  //!< its first bytes; none: any
  bool is_scan;  //!< a folder of such files is an input, too
  void (*read)(const std::string& path, ScanFile& out) = nullptr;  //!< one scan
  std::unique_ptr<ScanSource> (*open)(
      const std::vector<std::string>& paths, const SourceOptions& options) = nullptr;  //!< bags
  const char* how = "";  //!< where nothing reads it: what it is, and what to do; {} is its path
};

/** All formats: a new one is a row here, and its reader. */
inline const std::vector<Format> kFormats = {
    {{".bin"}, {}, true, read_bin},
    {{".pcd"}, {"# .PCD", "VERSION .7\n", "VERSION 0.7\n"}, true, read_pcd},
    {{".ply"}, {"ply\n", "ply\r"}, true, read_ply},
    {{".las", ".laz"},
     {"LASF"},
     true,
     nullptr,
     nullptr,
     "is a LAS or LAZ file, which no library of Debian's reads. 'pdal translate {} FILE.ply' "
     "(pdal.io) makes a .ply of it, which is read."},
    {{".bag"},
     {"#ROSBAG V2"},
     false,
     nullptr,
     nullptr,
     "is a ROS 1 bag. MRPT's 'rosbag2rawlog {} --config bag.yml --frame base_link --output "
     "LOG.rawlog' makes a log of it; doc/import_bags.md has a bag.yml."},
    {{".db3", ".mcap"}, {"SQLite format 3", "\x89MCAP0\r\n"}, false, nullptr, open_bag_source}};

/** Describes a ROS 2 bag, in its folder. */
constexpr const char* kBagDescription = "metadata.yaml";

/** A .db3 or .mcap, also one that was packed as a whole. */
bool is_file_of_bag(const std::string& path);

/** ".bin, .pcd or .ply": the scans that are read. */
std::string endings_of_scans();

/** The folder itself, or the one in it, where KITTI's layouts have their scans: `velodyne`,
 * `velodyne_points/data`. Empty: none has any. */
std::string folder_with_scans(const std::string& path);

/** Throws std::runtime_error: the file names its fields, and options.fields do so, too. */
[[noreturn]] void refuse_fields(const std::string& path);

}  // namespace talus::import
