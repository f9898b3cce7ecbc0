#pragma once
#include "kernels/atomics.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#if defined(TALUS_HAVE_TBB)
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#endif

namespace talus
{
struct OneThread
{
  using Atomics = kernels::SerialAtomics;
  int size() const { return 1; }
  template <class Body>
  void run_frame(const Body& body)
  {
    body();
  }
  template <class Body>
  void run(int n, int, const Body& body)
  {
    if (n > 0) body(0, n);
  }
};

/** A loop in pieces. Each thread has its own range of them, whose memory is still in its cache from
 * earlier loops; then it takes pieces of threads that are late. */
class SharedLoop
{
 public:
  explicit SharedLoop(int threads) : own_(static_cast<std::size_t>(threads)) {}

  /** body(begin, end) for pieces of [0, n), on this thread, the first, and all that call help(). */
  template <class Body>
  void run(int n, int piece, const Body& body)
  {
    call_ = [](const void* f, int begin, int end) { (*static_cast<const Body*>(f))(begin, end); };
    body_ = &body, n_ = n, piece_ = piece;
    const int pieces = (n + piece - 1) / piece, threads = static_cast<int>(own_.size());
    done_.store(0, std::memory_order_relaxed);
    for (int t = 0; t < threads; t++)
    {
      const auto begin = static_cast<std::uint64_t>(pieces * t / threads);
      const auto end = static_cast<std::uint64_t>(pieces * (t + 1) / threads);
      own_[static_cast<std::size_t>(t)].next.store(end << 32 | begin, std::memory_order_release);
    }
    while (help(0))
    {
    }
    wait([&] { return done_.load(std::memory_order_acquire) == pieces; });
    if (failed_.load(std::memory_order_relaxed)) rethrow();
  }

  /** Runs one piece as that thread; false if none is left. */
  bool help(std::size_t thread)
  {
    for (std::size_t t = thread; t < own_.size(); t++)
      if (take(own_[t].next)) return true;
    for (std::size_t t = 0; t < thread; t++)
      if (take(own_[t].next)) return true;
    return false;
  }

  /** Waits until `ready()`; lets others run when it takes long. */
  template <class Ready>
  static void wait(const Ready& ready)
  {
    for (int tries = 0; !ready(); tries++)
      if (tries > kTries) std::this_thread::yield();
  }

 private:
  /** The next piece of a thread, and in the upper half the end of its pieces. They are one number,
   * so that a late thread finds either a piece or none. */
  struct alignas(64) Own
  {
    std::atomic<std::uint64_t> next{0};
  };
  static constexpr int kTries = 1000;
  static bool any(std::uint64_t next) { return (next & 0xffffffffu) < next >> 32; }

  bool take(std::atomic<std::uint64_t>& own)
  {
    if (!any(own.load(std::memory_order_relaxed))) return false;
    const std::uint64_t next = own.fetch_add(1, std::memory_order_acquire);
    if (!any(next)) return false;
    const int begin = static_cast<int>(next & 0xffffffffu) * piece_;
    try
    {
      call_(body_, begin, std::min(begin + piece_, n_));
    }
    catch (...)
    {
      if (!failed_.exchange(true)) error_ = std::current_exception();
    }
    done_.fetch_add(1, std::memory_order_release);
    return true;
  }

  /** Rethrows the exception of a piece when all are done. */
  void rethrow()
  {
    failed_ = false;
    std::rethrow_exception(std::exchange(error_, nullptr));
  }

  void (*call_)(const void*, int, int) = nullptr;
  const void* body_ = nullptr;
  int n_ = 0, piece_ = 1;
  std::exception_ptr error_;
  std::atomic<bool> failed_{false};
  std::vector<Own> own_;
  alignas(64) std::atomic<int> done_{0};
};

#if defined(TALUS_HAVE_TBB)
/** A pool of oneTBB threads, called once for each frame, since loops are shorter than a call. */
class ThreadPool
{
 public:
  using Atomics = kernels::ThreadAtomics;
  explicit ThreadPool(int threads)
      : arena_(std::make_unique<tbb::task_arena>(threads)),
        loop_(std::make_unique<SharedLoop>(threads))
  {
  }
  int size() const { return arena_->max_concurrency(); }

  /** Calls the threads for all loops that `body` runs. */
  template <class Body>
  void run_frame(const Body& body)
  {
    std::atomic<bool> over{false};
    const auto help = [this, &over](int thread)
    {
      SharedLoop::wait(
          [&]
          {
            while (loop_->help(static_cast<std::size_t>(thread)))
            {
            }
            return over.load(std::memory_order_acquire);
          });
    };
    arena_->execute(
        [&]
        {
          tbb::task_group helpers;
          for (int t = 1; t < size(); t++) helpers.run([help, t] { help(t); });
          const auto end = [&]
          {
            called_ = false;
            over.store(true, std::memory_order_release);
            helpers.wait();
          };
          called_ = true;
          try
          {
            body();
          }
          catch (...)
          {
            end();
            throw;
          }
          end();
        });
  }

  /** body(begin, end) for pieces of [0, n), of `grain` or more, if possible as many a thread. */
  template <class Body>
  void run(int n, int grain, const Body& body)
  {
    if (n <= 0) return;
    int pieces = std::min((n + grain - 1) / grain, kPieces * size());
    if (pieces > size() && pieces < n) pieces -= pieces % size();
    const int piece = (n + pieces - 1) / pieces;
    if (n <= piece)
      body(0, n);
    else if (called_)
      loop_->run(n, piece, body);
    else
      run_frame([&] { loop_->run(n, piece, body); });
  }

 private:
  static constexpr int kPieces = 16;  //!< for each thread, since some pieces take longer
  std::unique_ptr<tbb::task_arena> arena_;
  std::unique_ptr<SharedLoop> loop_;
  bool called_ = false;
};
#endif

}  // namespace talus
