#include "cuda/copy_large.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

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

/** Threads that join in short work of some ten microseconds, too short to wake for. While work is
 * frequent they wait for it awake, else they sleep. Nobody waits for one that has not come. */
class StagingThreads
{
 public:
  explicit StagingThreads(int count)
  {
    for (int i = 0; i < count; i++) threads_.emplace_back([this] { serve(); });
  }
  ~StagingThreads()
  {
    {
      const std::lock_guard<std::mutex> lock(sleep_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& t : threads_) t.join();
  }

  /** Runs `own` on this thread and meanwhile `help` on helpers, which returns when nothing is left.
   * Returns, or throws the exception of `own`, when no helper is in it. Wakes sleeping helpers if
   * the work is long or frequent. Has no helpers while they work for another thread. */
  void work(const std::function<void()>& own, const std::function<void()>& help, bool is_long)
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

 private:
  void begin(const std::function<void()>& help, bool is_long)
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
  void end()
  {
    open_ = false;
    while (inside_) relax();
  }
  void serve()
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
  /** Waits for work after round `seen`. */
  void wait_for_work(unsigned seen)
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

  std::mutex turn_;  //!< held by the thread that they work for
  const std::function<void()>* help_ = nullptr;
  std::atomic<bool> open_{false};  //!< there is work to join
  std::atomic<int> inside_{0};  //!< helpers that are in the work, or about to be
  std::atomic<unsigned> round_{0};
  std::atomic<long long> last_ns_{0};  //!< when the last work came
  std::atomic<bool> often_{false};

  std::mutex sleep_;
  std::condition_variable wake_;
  std::atomic<int> asleep_{0};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

void copy_past_caches(char* to, const char* from, std::size_t bytes)
{
  std::size_t streamed = 0;
#if defined(__SSE2__)
  constexpr std::size_t kStep = 64, kWord = sizeof(__m128i);
  if (reinterpret_cast<std::uintptr_t>(to) % kWord == 0) streamed = bytes / kStep * kStep;
  for (std::size_t i = 0; i < streamed; i += kStep)
    for (std::size_t w = i; w < i + kStep; w += kWord)
      _mm_stream_si128(
          reinterpret_cast<__m128i*>(to + w),
          _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + w)));
  _mm_sfence();
#endif
  std::memcpy(to + streamed, from + streamed, bytes - streamed);
}

void copy_part(const CopyBlock& block, std::size_t begin, std::size_t size)
{
  copy_past_caches(
      static_cast<char*>(block.to) + begin, static_cast<const char*>(block.from) + begin,
      std::min(size, block.to_copy() - begin));
}

constexpr int kMaxHelpers = 5;
/** A smaller copy is done alone; below the second size threads are not woken. */
constexpr std::size_t kAlone = 96 * 1024, kLarge = 256 * 1024;
constexpr std::size_t kPiece = 32 * 1024;

/** Blocks in pieces; each thread takes the next one. */
class SharedCopy
{
 public:
  SharedCopy(const CopyBlock* blocks, int count) : blocks_(blocks), count_(count)
  {
    for (int b = 0; b < count; b++) left_[b] = pieces(b), pieces_ += left_[b];
  }

  /** Copies pieces while there are any; calls `after()` after each. */
  template <class F>
  void work(const F& after)
  {
    for (int i; (i = next_.fetch_add(1)) < pieces_; after())
    {
      int b = 0;
      for (; i >= pieces(b); b++) i -= pieces(b);
      copy_part(blocks_[b], kPiece * static_cast<std::size_t>(i), kPiece);
      left_[b].fetch_sub(1, std::memory_order_release);
    }
  }
  /** Calls `done` for the blocks that are complete. */
  void report(const std::function<void(int)>& done)
  {
    for (; reported_ < count_ && left_[reported_].load(std::memory_order_acquire) == 0; reported_++)
      done(reported_);
  }

 private:
  int pieces(int b) const { return static_cast<int>((blocks_[b].to_copy() + kPiece - 1) / kPiece); }

  const CopyBlock* blocks_;
  int count_, pieces_ = 0, reported_ = 0;
  std::atomic<int> next_{0}, left_[kMaxCopyBlocks];
};

int helper_count()
{
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()) - 1, 0, kMaxHelpers);
}

void copy_together(
    const CopyBlock* blocks, int count, bool large, const std::function<void(int)>& done)
{
  static StagingThreads helpers(helper_count());
  SharedCopy copy(blocks, count);
  helpers.work([&] { copy.work([&] { copy.report(done); }); }, [&] { copy.work([] {}); }, large);
  copy.report(done);
}
}  // namespace

void copy_blocks(const CopyBlock* blocks, int count, const std::function<void(int)>& done)
{
  std::size_t bytes = 0;
  for (int b = 0; b < count; b++) bytes += blocks[b].to_copy();
  if (bytes > kAlone)
  {
    copy_together(blocks, count, bytes > kLarge, done);
    return;
  }
  for (int b = 0; b < count; b++)
  {
    copy_part(blocks[b], 0, blocks[b].to_copy());
    done(b);
  }
}

}  // namespace talus
