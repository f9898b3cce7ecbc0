#include "device_schedule.h"

// Takes the place of the CUDA backend in an executable, so that both schedules can be compared
// where there is no device.
std::unique_ptr<talus::BackendInterface> talus::make_cuda_backend(const MapConfig& config, int)
{
  return test::make_device_schedule(config);
}

int talus::cuda_devices() { return 1; }
