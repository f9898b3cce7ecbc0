// ROS 2 bags: the file itself says whether it is SQLite or MCAP.
#include <cmath>
#include <cstddef>

#include "formats.h"
#include "fuzz.h"

using namespace talus;
using namespace talus::import;

namespace
{
void check(const ImportedScan& scan)
{
  const std::size_t points = scan.x_m.size();
  fuzz::require(scan.y_m.size() == points && scan.z_m.size() == points, "each point has x, y, z");
  for (const std::size_t count :
       {scan.intensity.size(), scan.point_time_s.size(), scan.ring.size()})
    fuzz::require(count == 0 || count == points, "all points have it, or none");
  for (const auto* numbers : {&scan.x_m, &scan.y_m, &scan.z_m, &scan.point_time_s})
    for (const float number : *numbers) fuzz::require(std::isfinite(number), "points are finite");
  fuzz::require(std::isfinite(scan.time_s), "scans have a time");
  fuzz::require(std::isfinite(scan.T_base_sensor.norm()), "mountings are finite");
}
}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const fuzz::InputFile file(data, size, ".bag");
  for (const bool partial : {false, true})
    fuzz::is_read(
        [&]
        {
          SourceOptions options;
          options.partial = partial;
          const auto source = open_bag_source({file.path()}, options);
          ImportedScan scan;
          while (source->next(scan)) check(scan);
          fuzz::require(source->progress() <= 1, "no more than all is read");
          const auto poses = source->poses();
          for (const auto& pose : poses.entries())
            fuzz::require(std::isfinite(pose.T_map_base.norm()), "poses are finite");
          source->remarks();
        });
  return 0;
}
