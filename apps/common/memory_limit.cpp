#include "memory_limit.h"

#if defined(__GLIBC__)
#include <malloc.h>
#include <sys/mman.h>
#endif
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>

namespace talus::app
{
namespace
{
/** 0 when it is unknown. */
std::size_t address_space_bytes()
{
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}
}  // namespace

MemoryLimit::MemoryLimit(std::size_t more_bytes)
{
  const std::size_t now_bytes = address_space_bytes();
  if (now_bytes == 0 || ::getrlimit(RLIMIT_AS, &before_) != 0) return;
  rlimit limit = before_;
  limit.rlim_cur = std::min<rlim_t>(before_.rlim_cur, now_bytes + more_bytes);
  is_set_ = ::setrlimit(RLIMIT_AS, &limit) == 0;
}

MemoryLimit::~MemoryLimit()
{
  if (is_set_) ::setrlimit(RLIMIT_AS, &before_);
}

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
