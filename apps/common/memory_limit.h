#pragma once
#include <sys/resource.h>

#include <cstddef>

namespace talus::app
{
/** While it lives, this process gets at most so much memory more than it has: a log may be damaged
 * where it says how much follows, and its reader asks for that much. Then std::bad_alloc is thrown.
 * Of the whole process: not for two threads at once. */
class MemoryLimit
{
 public:
  explicit MemoryLimit(std::size_t more_bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
  bool is_set_ = false;
};

}  // namespace talus::app
