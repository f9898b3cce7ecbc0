#include "executor_cpu.h"
#include "pipeline.h"

#include <thread>

namespace talus
{
std::unique_ptr<BackendInterface> make_cpu_backend(const kernels::Config& config, int threads)
{
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
#if defined(TALUS_HAVE_TBB)
  if (threads > 1)
    return std::make_unique<Pipeline<CpuExecutor<ThreadPool>>>(
        config, CpuExecutor<ThreadPool>{ThreadPool{threads}});
#endif
  return std::make_unique<Pipeline<CpuExecutor<OneThread>>>(
      config, CpuExecutor<OneThread>{OneThread{}});
}

}  // namespace talus
