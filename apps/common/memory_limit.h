#pragma once
#include <cstddef>
#include <string>
#include <sys/resource.h>

namespace talus::app
{
/** While it lives, this process gets no more than `more_bytes` of memory beyond what it has: a log
 * may be damaged where it says how much follows, and its reader asks for that much. Then
 * std::bad_alloc is thrown. Of the whole process: not for two threads at once. */
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

/** From now on memory that was given back is kept for what comes next, in large pages where there
 * are such: a command that makes as much again for each scan would spend a sixth of its time on
 * pages that it had before. It never has more than what it needed at once. */
void keep_memory();

/** How much memory reading a log or a trajectory may take [bytes]: what its bytes can hold and
 * 100 MB, 2 GB at most. A count in it that is damaged asks for anything. The 100 MB and the 2 GB
 * are shared by the processes that share_log_memory() named. */
std::size_t memory_for_log(const std::string& path);

/** From now on this number of processes read logs at once: this one and its children get a part
 * each. */
void share_log_memory(std::size_t processes);

}  // namespace talus::app
