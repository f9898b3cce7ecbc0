#pragma once
#include <talus/import/scan_source.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace talus::import
{
/** The files of a folder of scans; those that are not there are empty. */
struct FolderLayout
{
  std::vector<std::string> scans;  //!< in the order of their names; one at least
  const Format* format = nullptr;  //!< of all of them
  std::string label;  //!< of the sensor: the name of the folder
  std::string times, calibration, poses;
  std::string kitti_360;  //!< its folder `calibration`
};

/** Looks into a folder, or beside a single file. KITTI's layouts: a sequence of the odometry data
 * (velodyne/, times.txt, calib.txt; poses.txt in it or poses/NN.txt beside sequences/), a drive of
 * the raw data (velodyne_points/), one of KITTI-360 (below data_3d_raw/). Throws std::runtime_error
 * that names the folder, what is wrong and what to do. */
FolderLayout find_layout(const Input& input);

/** What the poses of a folder of scans say. */
struct FolderPoses
{
  std::string tum;  //!< a trajectory over time; else empty
  std::vector<double> times_s;  //!< of those in `tum`, where they say the times of the scans
  /** Of the sensor, one a scan; a scan may have none. Empty: all have none. */
  std::vector<std::optional<mrpt::poses::CPose3D>> T_map_sensor;
  std::size_t scans =
      0;  //!< count of the first scans that are read: those with poses, by --partial
};

/** Reads `path`, which is not empty. `have_times`: something else says when the scans were taken.
 * Throws std::runtime_error that names the file, what is wrong and which option helps. */
FolderPoses read_folder_poses(
    const std::string& path, const FolderLayout& layout, const SourceOptions& options,
    bool have_times);

/** Seconds, a line a scan: whole files of KITTI's `times.txt` (seconds) or `timestamps.txt` (dates,
 * of UTC). Ascending. Throws std::runtime_error that names the file, the line and what is wrong. */
std::vector<double> read_times(const std::string& path);

/** The number that the name of a scan's file is; nothing where it is none. */
std::optional<std::size_t> number_of_scan(const std::string& scan);

/** Whether all names are numbers of lines, from 0 on. */
bool have_lines_by_number(const std::vector<std::string>& scans, std::size_t lines);

/** Which line of a file with `lines` of them belongs to which of the scans: by the numbers that
 * their files have for names (from 0 on), or one after the other where there are as many lines as
 * scans. Throws std::runtime_error that names `path` where neither fits. */
std::vector<std::size_t> lines_of_scans(
    const std::vector<std::string>& scans, std::size_t lines, const std::string& path);

/** The numbers that the names of all files are, behind a common word such as cloud_, as text.
 * SECONDS_NANOSECONDS, and SECONDS.NANOSECONDS where the folder as a whole shows that these do
 * without leading zeros, get a point and the zeros. Empty: some name is no number. */
std::vector<std::string> numbers_of_names(const std::vector<std::string>& scans);

/** The seconds since the epoch that the names of all files are: in seconds, milli-, micro- or
 * nanoseconds, or as dates of UTC from the year to the second or its fraction, or of another
 * beginning where all have a decimal point; ascending. Empty: they are no times. */
std::vector<double> times_of_names(const std::vector<std::string>& scans);

}  // namespace talus::import
