#include "memory_limit.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace talus::app
{
void keep_memory()
{
#if defined(__GLIBC__)
  constexpr int kLargest = 32 << 20;  // that malloc may take from its heap
  constexpr int kAhead = 256 << 20;  // addresses, not memory
  constexpr std::uintptr_t kPage = 2 << 20;
  mallopt(M_MMAP_THRESHOLD, kLargest);
  mallopt(M_TRIM_THRESHOLD, -1);  // never
  mallopt(M_TOP_PAD, kAhead);
  const auto aligned = [](void* at)
  { return (reinterpret_cast<std::uintptr_t>(at) + kPage - 1) / kPage * kPage; };
  const std::uintptr_t begin = aligned(sbrk(0));
  std::free(std::malloc(kPage));
  const std::uintptr_t end = aligned(sbrk(0));
  if (end > begin + kPage)
    madvise(reinterpret_cast<void*>(begin), end - begin - kPage, MADV_HUGEPAGE);
#endif
}

}  // namespace talus::app
