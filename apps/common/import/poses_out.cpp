#include "merged_sources.h"

#include "../memory_limit.h"
#include "../crash_context.h"
#include "rawlog_writer.h"

#include <talus/import/kitti_poses.h>
#include <talus/input_file.h>
#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>

namespace talus::import
{
namespace
{
bool is_simplemap(const std::string& path)
{
  return path.find(".simplemap", path.rfind('/') + 1) != std::string::npos;
}

std::string text_of(const io::Trajectory& trajectory)
{
  std::string text = "# t[s] x[m] y[m] z[m] qx qy qz qw of the base in the map\n";
  for (const auto& entry : trajectory.entries()) text += io::tum_line(entry);
  return text;
}

WrittenPoses measured(const io::Trajectory& trajectory, const std::string& source)
{
  WrittenPoses written;
  const auto& entries = trajectory.entries();
  written.count = entries.size();
  written.source = source;
  if (entries.empty()) return written;
  written.first_s = entries.front().time_s;
  written.last_s = entries.back().time_s;
  for (std::size_t i = 1; i < entries.size(); ++i)
    written.length_m += entries[i].T_map_base.distanceTo(entries[i - 1].T_map_base);
  return written;
}
}  // namespace

WrittenPoses write_poses(
    const std::string& tum, const SourceOptions& options, MergedSources& sources)
{
  const std::string& poses = options.poses;
  constexpr std::uint64_t kMax_bytes = std::uint64_t{1} << 30;
  if (!poses.empty() && !options.poses_of_sensor && !is_kitti_poses(poses))
  {
    const auto trajectory = app::guarded(
        poses, app::kCompareWithSource, [&] { return io::Trajectory::load(poses); },
        app::memory_for_log(poses));
    std::string ignored;
    const auto placed = sources.poses(ignored);  // at other times where the file counts scans
    const bool is_counted =
        !placed.empty() && placed.entries().front().time_s != trajectory.entries().front().time_s;
    io::write_file(
        tum, is_counted || is_simplemap(poses) ? text_of(is_counted ? placed : trajectory)
                                               : read_input_file(poses, "trajectory", kMax_bytes));
    return measured(is_counted ? placed : trajectory, poses);
  }
  std::string source;
  const auto trajectory = sources.poses(source);
  if (!poses.empty()) source = poses;
  if (trajectory.empty() && !poses.empty())
    throw std::runtime_error(
        poses +
        ": has poses of KITTI's camera; they go with a folder of scans that has a "
        "calib.txt. Pass poses of the base, as TUM text.");
  if (!trajectory.empty()) io::write_file(tum, text_of(trajectory));
  return measured(trajectory, source);
}

}  // namespace talus::import
