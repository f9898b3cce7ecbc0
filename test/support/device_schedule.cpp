#include "cuda/device.h"
#include "device_on_host.h"
#include "device_schedule.h"
#include "map_backend.h"

std::unique_ptr<talus::BackendInterface> talus::test::make_device_schedule(const MapConfig& config)
{
  return std::make_unique<MapBackend<Device<DeviceOnHost>>>(config, DeviceOnHost{});
}
