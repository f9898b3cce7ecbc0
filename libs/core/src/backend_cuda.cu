#include "executor_cuda_frame.cuh"
#include "pipeline.h"

namespace talus
{
std::unique_ptr<BackendInterface> make_cuda_backend(const kernels::Config& config)
{
  return std::make_unique<Pipeline<CudaExecutor>>(config, CudaExecutor());
}

}  // namespace talus
