#pragma once
#include <string>

namespace talus::io
{
/** Scans of other programs. */
enum class ForeignScans
{
  None,  //!< nothing that is known, or nothing there
  Folder,  //!< of .bin, .pcd, .ply, .las or .laz files
  Bin,  //!< by its ending: KITTI's files have no mark
  Pcd,
  Ply,
  Las,  //!< and .laz
  Ros1Bag,
  Ros2Bag  //!< the folder, or a file of it
};

/** By the first bytes; by the ending where these do not tell. Opens regular files only. */
ForeignScans kind_of_scans(const std::string& path);

/** By the ending alone. */
ForeignScans kind_by_ending(const std::string& path);

/** The folder itself, or the one in it, where KITTI's layouts have their scans: `velodyne`,
 * `velodyne_points/data`. Empty: none has any. */
std::string folder_with_scans(const std::string& path);

/** One or more sentences that say how scans of that kind get into a rawlog; "" for None. */
std::string how_to_import(const std::string& path, ForeignScans kind);

}  // namespace talus::io
