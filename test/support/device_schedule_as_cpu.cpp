#include "cuda/schedule.h"
#include "device_on_host.h"
#include "map_backend.h"

// Takes the place of the CPU backend in an executable: what is specified of that one then holds for
// the device's schedule.

namespace talus
{
std::unique_ptr<BackendInterface> make_cpu_backend(const MapConfig& config, int)
{
  return std::make_unique<MapBackend<DeviceSchedule<test::DeviceOnHost>>>(
      config, test::DeviceOnHost{});
}
}  // namespace talus
