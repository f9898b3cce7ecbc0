#pragma once
// ThreadSanitizer sees only what was compiled with it, and Debian's oneTBB was not: what one of its
// tasks hands to the next looks like a race. So the build with it (preset tsan) has these threads
// instead, which begin and end as tasks do; the loops that they share (cpu_threads.h) are the real
// ones, and nothing has to be suppressed.
namespace tbb
{
class task_arena
{
 public:
  explicit task_arena(int threads) : threads_(threads) {}
  int max_concurrency() const { return threads_; }
  template <class Body>
  void execute(const Body& body)
  {
    body();
  }

 private:
  int threads_;
};
}  // namespace tbb
