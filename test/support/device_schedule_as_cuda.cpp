#include "cuda/schedule.h"
#include "device_on_host.h"
#include "map_backend.h"

// Takes the place of the CUDA backend in an executable, so that both schedules can be compared
// where there is no device.

namespace talus
{
std::unique_ptr<BackendInterface> make_cuda_backend(const MapConfig& config, int)
{
  return std::make_unique<MapBackend<DeviceSchedule<test::DeviceOnHost>>>(
      config, test::DeviceOnHost{});
}

int cuda_devices() { return 1; }
}  // namespace talus
