#include "cpu/cores.h"
#include "map_backend.h"

#include <algorithm>
#include <thread>

namespace talus
{
std::unique_ptr<BackendInterface> make_cpu_backend(const MapConfig& config, int threads)
{
#if defined(TALUS_HAVE_TBB)
  constexpr int kMaxThreads = 1024;  // pieces of a loop are counted in an int
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  threads = std::min(threads, kMaxThreads);
  if (threads > 1)
    return std::make_unique<MapBackend<Cores<ThreadPool>>>(
        config, CpuExecutor<ThreadPool>{ThreadPool{threads}});
#else
  static_cast<void>(threads);
#endif
  return std::make_unique<MapBackend<Cores<OneThread>>>(
      config, CpuExecutor<OneThread>{OneThread{}});
}

}  // namespace talus
