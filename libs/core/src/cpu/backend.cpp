#include "cpu/schedule.h"
#include "map_backend.h"

#include <algorithm>
#include <thread>

namespace talus
{
namespace
{
constexpr int kMostThreads = 1024;  //!< pieces of a loop are counted in an int
}

std::unique_ptr<BackendInterface> make_cpu_backend(const MapConfig& config, int threads)
{
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  threads = std::min(threads, kMostThreads);
#if defined(TALUS_HAVE_TBB)
  if (threads > 1)
    return std::make_unique<MapBackend<CpuSchedule<ThreadPool>>>(
        config, CpuExecutor<ThreadPool>{ThreadPool{threads}});
#endif
  return std::make_unique<MapBackend<CpuSchedule<OneThread>>>(
      config, CpuExecutor<OneThread>{OneThread{}});
}

}  // namespace talus
