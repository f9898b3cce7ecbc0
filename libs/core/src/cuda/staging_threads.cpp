#include "cuda/staging_threads.h"

#include <chrono>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace talus
{
namespace
{
/** Work within this time of the last is frequent; threads stay awake no longer. */
constexpr long long kOften_ns = 1'000'000;

long long now_ns()
{
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void relax()
{
#if defined(__SSE2__)
  _mm_pause();
#endif
}
}  // namespace

StagingThreads::StagingThreads(int count)
{
  for (int i = 0; i < count; i++) threads_.emplace_back([this] { serve(); });
}

StagingThreads::~StagingThreads()
{
  {
    const std::lock_guard<std::mutex> lock(sleep_);
    stop_ = true;
  }
  wake_.notify_all();
  for (std::thread& t : threads_) t.join();
}

void StagingThreads::work(
    const std::function<void()>& own, const std::function<void()>& help, bool is_long)
{
  const std::unique_lock<std::mutex> turn(turn_, std::try_to_lock);
  if (!turn)
  {
    own();
    return;
  }
  struct End
  {
    StagingThreads& helpers;
    ~End() { helpers.end(); }
  };
  begin(help, is_long);
  const End end{*this};
  own();
}

void StagingThreads::begin(const std::function<void()>& help, bool is_long)
{
  const long long now = now_ns();
  often_ = now - last_ns_.exchange(now) < kOften_ns;
  help_ = &help;
  open_ = true;
  round_++;
  if (asleep_ == 0 || !(is_long || often_)) return;
  {
    const std::lock_guard<std::mutex> lock(sleep_);
  }
  wake_.notify_one();
}

void StagingThreads::end()
{
  open_ = false;
  while (inside_) relax();
}

void StagingThreads::serve()
{
  for (unsigned seen = 0;;)
  {
    wait_for_work(seen);
    if (stop_) return;
    seen = round_;
    inside_++;
    if (open_) (*help_)();
    inside_--;
  }
}

void StagingThreads::wait_for_work(unsigned seen)
{
  const auto is_time = [&] { return stop_ || round_ != seen; };
  while (often_ && now_ns() - last_ns_ < kOften_ns)
    for (int i = 0; i < 64; i++)
    {
      if (is_time()) return;
      relax();
    }
  std::unique_lock<std::mutex> lock(sleep_);
  asleep_++;
  wake_.wait(lock, is_time);
  asleep_--;
  lock.unlock();
  if (asleep_ > 0) wake_.notify_one();  // each wakes the next, so that work() need not
}

}  // namespace talus
