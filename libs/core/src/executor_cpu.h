#pragma once
#include <talus/frame.h>
#include "kernels/1_accept.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#if defined(TALUS_HAVE_TBB)
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace talus
{
/** What both CPU executors share: memory is plain, copies are copies, time is the steady clock. */
class CpuMemory
{
 public:
  template <class T>
  using Buffer = std::vector<T>;

  template <class T>
  void allocate(Buffer<T>& buffer, std::size_t size, T value)
  {
    buffer.assign(size, value);
  }
  template <class T>
  void upload(const T* from, std::size_t size, Buffer<T>& to)
  {
    to.assign(from, from + size);
  }
  template <class T, class U>
  void download(const Buffer<T>& from, U* to, std::size_t size, std::size_t offset = 0)
  {
    std::copy_n(from.data() + offset, size, to);
  }
  /** The caller's own memory. */
  kernels::PointsIn upload_points(const Frame& f) { return {f.x_m, f.y_m, f.z_m, f.time_s}; }

  std::string name() const { return "cpu"; }

  void start_clock() { start_ = last_ = Clock::now(); }
  double lap_ms()
  {
    const auto now = Clock::now();
    return milliseconds(std::exchange(last_, now), now);
  }
  double total_ms() const { return milliseconds(start_, Clock::now()); }

 private:
  using Clock = std::chrono::steady_clock;
  static double milliseconds(Clock::time_point a, Clock::time_point b)
  {
    return std::chrono::duration<double, std::milli>(b - a).count();
  }
  Clock::time_point start_, last_;
};

/** Runs the stages' loops one after the other. An executor supplies buffers, loops and the atomics
 * that its threads need; it knows nothing of the map. */
class SerialExecutor : public CpuMemory
{
 public:
  using Atomics = kernels::SerialAtomics;

  /** f(i) for i in [0, n) */
  template <class F>
  void for_each(int n, const F& f)
  {
    for (int i = 0; i < n; i++) f(i);
  }

  /** f(x, y) for x in [0, nx), y in [0, ny) */
  template <class F>
  void for_each_cell(int nx, int ny, const F& f)
  {
    for (int y = 0; y < ny; y++)
      for (int x = 0; x < nx; x++) f(x, y);
  }

  template <class T>
  void fill(Buffer<T>& buffer, T value)
  {
    std::fill(buffer.begin(), buffer.end(), value);
  }
};

#if defined(TALUS_HAVE_TBB)
/** The same with oneTBB threads. */
class ThreadExecutor : public CpuMemory
{
 public:
  using Atomics = kernels::ThreadAtomics;
  explicit ThreadExecutor(int threads) : arena_(std::make_unique<tbb::task_arena>(threads)) {}

  template <class F>
  void for_each(int n, const F& f)
  {
    run(n, 1024,
        [&f](int begin, int end)
        {
          for (int i = begin; i < end; i++) f(i);
        });
  }

  template <class F>
  void for_each_cell(int nx, int ny, const F& f)
  {
    run(ny, std::max(1, 4096 / std::max(nx, 1)),
        [&f, nx](int begin, int end)
        {
          for (int y = begin; y < end; y++)
            for (int x = 0; x < nx; x++) f(x, y);
        });
  }

  template <class T>
  void fill(Buffer<T>& buffer, T value)
  {
    std::fill(buffer.begin(), buffer.end(), value);
  }

 private:
  template <class Body>
  void run(int n, int grain, const Body& body)
  {
    arena_->execute(
        [&]
        {
          tbb::parallel_for(
              tbb::blocked_range<int>(0, n, static_cast<std::size_t>(grain)),
              [&](const tbb::blocked_range<int>& r) { body(r.begin(), r.end()); });
        });
  }
  std::unique_ptr<tbb::task_arena> arena_;
};
#endif

}  // namespace talus
