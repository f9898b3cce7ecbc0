#include "cuda/device.h"
#include "cuda/executor.cuh"
#include "map_backend.h"

namespace talus
{
std::unique_ptr<BackendInterface> make_cuda_backend(const MapConfig& config, int device)
{
  return std::make_unique<MapBackend<Device<CudaExecutor>>>(config, CudaExecutor(device));
}

int cuda_devices()
{
  int devices = 0;
  const cudaError_t answer = cudaGetDeviceCount(&devices);
  static_cast<void>(cudaGetLastError());
  return answer == cudaSuccess ? devices : 0;
}

}  // namespace talus
