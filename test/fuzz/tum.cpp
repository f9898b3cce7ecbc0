// Poses as TUM text: what is read is in order of time, finite, and can be asked.
#include <talus/io/trajectory.h>

#include <cmath>

#include "fuzz.h"

using talus::io::Trajectory;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace talus;
  const fuzz::InputFile file(data, size, ".tum");
  Trajectory trajectory;
  if (!fuzz::is_read([&] { trajectory = Trajectory::load(file.path()); })) return 0;
  fuzz::require(!trajectory.empty(), "a file without poses is refused");
  double before_s = -INFINITY;
  for (const auto& entry : trajectory.entries())
  {
    fuzz::require(before_s < entry.time_s, "times ascend");
    if (const auto pose = trajectory.at(0.5 * (before_s + entry.time_s), 1e9))
      fuzz::require(std::isfinite(pose->norm()), "a pose between two is finite");
    before_s = entry.time_s;
  }
  return 0;
}
