// Scans of other programs, and the texts beside them: the first byte says of which kind, the rest
// is the file.
#include <talus/import/kitti_poses.h>

#include <cmath>
#include <cstddef>

#include "formats.h"
#include "fuzz.h"
#include "folder_layout.h"
#include "point_times.h"

using namespace talus;
using namespace talus::import;

namespace
{
void look_at_scan(const std::string& path, void (*read)(const std::string&, ScanFile&))
{
  ScanFile scan;
  if (!fuzz::is_read([&] { read(path, scan); })) return;
  const std::size_t points = scan.x_m.size();
  fuzz::require(scan.y_m.size() == points && scan.z_m.size() == points, "each point has x, y, z");
  for (const std::size_t count : {scan.intensity.size(), scan.time.size(), scan.ring.size()})
    fuzz::require(count == 0 || count == points, "all points have it, or none");
  for (const auto* axis : {&scan.x_m, &scan.y_m, &scan.z_m})
    for (const double number : *axis)
      fuzz::require(std::isfinite(static_cast<float>(number)), "points are finite");
  PointClock clock;
  clock.add(scan, 1.7e9);
  clock.leave_out_broken(scan);
  fuzz::require(
      scan.time.empty() || scan.time.size() == scan.x_m.size(), "each point keeps its time");
  for (const float time_s : clock.times_since(1.7e9, scan))
    fuzz::require(std::isfinite(time_s), "times are finite");
}

void look_at_times(const std::string& path)
{
  std::vector<double> times_s;
  if (!fuzz::is_read([&] { times_s = read_times(path); })) return;
  double before_s = -INFINITY;
  for (const double time_s : times_s)
  {
    fuzz::require(before_s < time_s && std::isfinite(time_s), "times ascend");
    before_s = time_s;
  }
}

void look_at_poses(const std::string& path)
{
  std::vector<mrpt::poses::CPose3D> poses;
  fuzz::is_read([&] { poses.push_back(read_kitti_calibration(path)); });
  fuzz::is_read(
      [&]
      {
        is_kitti_poses(path);
        const auto read = read_kitti_poses(path);
        poses.insert(poses.end(), read.poses.begin(), read.poses.end());
        fuzz::require(
            read.frames.empty() || read.frames.size() == read.poses.size(),
            "all poses have a frame, or none");
      });
  for (const auto& pose : poses)
    fuzz::require(std::isfinite(pose.yaw()) && std::isfinite(pose.norm()), "poses are finite");
}
}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size == 0) return 0;
  const int kind = data[0] % 5;
  const fuzz::InputFile file(data + 1, size - 1, ".scan");
  switch (kind)
  {
    case 0:
      look_at_scan(file.path(), read_pcd);
      break;
    case 1:
      look_at_scan(file.path(), read_ply);
      break;
    case 2:
      look_at_scan(file.path(), read_bin);
      look_at_scan(
          file.path(),
          [](const auto& path, ScanFile& scan)
          {
            scan.fields = {"x", "y", "z", "intensity", "ring"};
            read_bin(path, scan);
          });
      break;
    case 3:
      look_at_times(file.path());
      break;
    default:
      look_at_poses(file.path());
      break;
  }
  return 0;
}
