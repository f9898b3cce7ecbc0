#include "memory_limit.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace talus::app
{
namespace
{
/** 0 when the system does not tell. */
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

}  // namespace talus::app
