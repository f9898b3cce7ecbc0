#pragma once
// See task_arena.h.
#include <thread>
#include <vector>

namespace tbb
{
class task_group
{
 public:
  task_group() = default;
  task_group(const task_group&) = delete;
  task_group& operator=(const task_group&) = delete;
  ~task_group() { wait(); }
  template <class Body>
  void run(const Body& body)
  {
    threads_.emplace_back(body);
  }
  void wait()
  {
    for (auto& thread : threads_) thread.join();
    threads_.clear();
  }

 private:
  std::vector<std::thread> threads_;
};
}  // namespace tbb
