#include "copy_large.h"

#include <algorithm>
#include <cstring>

#if defined(TALUS_HAVE_TBB)
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace talus
{
namespace
{
#if defined(TALUS_HAVE_TBB)
constexpr int kThreads = 4;
constexpr std::size_t kAlone = 128 * 1024;  //!< smaller blocks are not worth waking threads for

void copy_together(char* to, const char* from, std::size_t bytes)
{
  static tbb::task_arena arena(kThreads);
  const std::size_t part = (bytes + kThreads - 1) / kThreads;
  arena.execute(
      [&]
      {
        tbb::parallel_for(
            0, kThreads,
            [&](int i)
            {
              const std::size_t begin = std::min(part * static_cast<std::size_t>(i), bytes);
              std::memcpy(to + begin, from + begin, std::min(part, bytes - begin));
            },
            tbb::static_partitioner());
      });
}
#endif
}  // namespace

void copy_large(void* to, const void* from, std::size_t bytes)
{
#if defined(TALUS_HAVE_TBB)
  if (bytes > kAlone)
  {
    copy_together(static_cast<char*>(to), static_cast<const char*>(from), bytes);
    return;
  }
#endif
  std::memcpy(to, from, bytes);
}

}  // namespace talus
