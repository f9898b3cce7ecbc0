#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace talus::import
{
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

/** The seconds since the epoch that the names of all files are: in seconds, milli-, micro- or
 * nanoseconds; ascending. Empty: they are no times. */
std::vector<double> times_of_names(const std::vector<std::string>& scans);

}  // namespace talus::import
