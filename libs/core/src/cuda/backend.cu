#include "cuda/executor_frame.cuh"
#include "cuda/schedule.h"
#include "map_backend.h"

namespace talus
{
std::unique_ptr<BackendInterface> make_cuda_backend(const MapConfig& config)
{
  return std::make_unique<MapBackend<DeviceSchedule<CudaExecutor>>>(config, CudaExecutor());
}

}  // namespace talus
