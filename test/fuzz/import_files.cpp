// Scans of other programs: the first byte says of which kind, the rest is the file.
#include <cmath>
#include <cstddef>

#include "fuzz.h"
#include "scan_files.h"

using namespace talus;
using namespace talus::import;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  struct Kind
  {
    const char* ending;
    void (*read)(const std::string&, ScanFile&);
  };
  constexpr Kind kKinds[] = {{".pcd", read_pcd}, {".ply", read_ply}, {".bin", read_kitti_bin}};
  if (size == 0) return 0;
  const Kind& kind = kKinds[data[0] % 3];
  const fuzz::InputFile file(data + 1, size - 1, kind.ending);
  ScanFile scan;
  if (!fuzz::is_read([&] { kind.read(file.path(), scan); })) return 0;
  const std::size_t points = scan.x_m.size();
  fuzz::require(scan.y_m.size() == points && scan.z_m.size() == points, "each point has x, y, z");
  for (const std::size_t count : {scan.intensity.size(), scan.time.size(), scan.ring.size()})
    fuzz::require(count == 0 || count == points, "all points have it, or none");
  for (const auto* axis : {&scan.x_m, &scan.y_m, &scan.z_m})
    for (const float number : *axis) fuzz::require(std::isfinite(number), "points are finite");
  for (const float time_s : times_since(1.7e9, scan, time_unit_s(scan)))
    fuzz::require(std::isfinite(time_s), "times are finite");
  return 0;
}
