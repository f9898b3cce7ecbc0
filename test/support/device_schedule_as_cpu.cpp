#include "device_schedule.h"

// Takes the place of the CPU backend in an executable: what is specified of that one then holds for
// the device's schedule.
std::unique_ptr<talus::BackendInterface> talus::make_cpu_backend(const MapConfig& config, int)
{
  return test::make_device_schedule(config);
}
