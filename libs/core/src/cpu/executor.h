#pragma once
#include "backend.h"
#include "cpu/buffer.h"
#include "cpu/loops.h"
#include "cpu/threads.h"
#include "kernels/1_points.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace talus
{
/** The common part of both CPU executors: plain memory, plain copies, the steady clock. */
class CpuMemory
{
 public:
  static constexpr bool kIsDevice = false;
  template <class T>
  using Buffer = std::vector<T, CellMemory<T>>;

  template <class T>
  void allocate(Buffer<T>& buffer, std::size_t size, T value)
  {
    buffer.assign(size, value);
  }
  template <class T>
  using HostBuffer = std::vector<T>;
  /** Grows a buffer to at least `size`; its contents are lost. */
  template <class T>
  void make_room(HostBuffer<T>& buffer, std::size_t size)
  {
    if (buffer.size() < size) buffer.resize(size);
  }
  /** Copies between the host and the memory of the map. */
  template <class T>
  void transfer(const T* from, std::size_t size, T* to)
  {
    copy(to, from, size);
  }
  template <class T>
  void copy(T* to, const T* from, std::size_t size)
  {
    std::copy_n(from, size, to);
  }
  void synchronize() {}
  void mark() {}
  void wait_for_mark() {}

  OutputMemory map_output(float* host, std::size_t) { return {host, true}; }
  void forget_outputs() {}

  std::string name() const { return "cpu"; }

  // ---- the frame of the slot in use ----
  void use(int slot) { now_ = static_cast<std::size_t>(slot); }
  int loop_size(int points, std::size_t) const { return points; }
  PointArrays point_arrays(std::size_t capacity)
  {
    slots_[now_].points.resize(4 * capacity);
    float* p = slots_[now_].points.data();
    return {p, p + capacity, p + 2 * capacity, p + 3 * capacity};
  }
  /** The points stay in the caller's memory. */
  kernels::PointsIn stage(const Frame& f, const kernels::FrameContext& context, std::size_t)
  {
    slots_[now_].context = &context;
    return {f.x_m, f.y_m, f.z_m, f.time_s};
  }
  /** The values of the channels stay there, too; null: the frame has none of that channel. */
  ChannelArrays stage_channels(const Frame& f, std::size_t, std::size_t) { return f.channels; }
  /** finish_frame() does all the work. */
  template <class Body>
  void start_frame(const Body&, bool)
  {
  }
  void start_clock()
  {
    start_ = last_ = Clock::now();
    stage_ms_ = {};
  }
  void fetch(Buffer<kernels::FrameContext>& context) { context.assign(1, *slots_[now_].context); }
  /** The counts of a frame, after report(). */
  kernels::FrameCounts* reported() { return &counts_; }
  /** Hands over the counts and clears them for the next frame. */
  void report(Buffer<kernels::FrameCounts>& counts) { counts_ = std::exchange(counts[0], {}); }
  /** Adds the time since the last lap to a stage. */
  void end_stage(Stage stage)
  {
    const auto now = Clock::now();
    stage_ms_[static_cast<std::size_t>(stage)] += milliseconds(std::exchange(last_, now), now);
  }
  /** Adds the time of `body` to a stage other than the current one. */
  template <class Body>
  void for_another_stage(Stage stage, const Body& body)
  {
    const auto before = Clock::now();
    body();
    const auto after = Clock::now();
    stage_ms_[static_cast<std::size_t>(stage)] += milliseconds(before, after);
    last_ += after - before;
  }
  std::array<double, kStageCount> stage_ms() const { return stage_ms_; }
  double total_ms() const { return milliseconds(start_, Clock::now()); }

 private:
  using Clock = std::chrono::steady_clock;
  static double milliseconds(Clock::time_point a, Clock::time_point b)
  {
    return std::chrono::duration<double, std::milli>(b - a).count();
  }
  Clock::time_point start_, last_;
  std::array<double, kStageCount> stage_ms_{};
  struct Slot
  {
    const kernels::FrameContext* context = nullptr;
    std::vector<float> points;  //!< for point_arrays()
  };
  std::array<Slot, kSlots> slots_;
  std::size_t now_ = 0;
  kernels::FrameCounts counts_{};
};

/** Runs the loops of the stages, on buffers, with the atomics of its threads. It knows no map. */
template <class Threads>
class CpuExecutor : public CpuMemory
{
 public:
  using Atomics = typename Threads::Atomics;
  explicit CpuExecutor(Threads threads) : threads_(std::move(threads)) {}

  template <class Body, class Then>
  void finish_frame(const Body& body, const Then& then)
  {
    start_clock();
    threads_.run_frame(body);
    then();
  }

  /** f(i) for i in [0, n), about `grain` of them at once. */
  template <class F>
  void for_each(int n, const F& f, int grain = 1024)
  {
    run(n, grain,
        [&f](int begin, int end)
        {
          for (int i = begin; i < end; i++) f(i);
        });
  }
  template <class Rule>
  void for_each(const kernels::Map& m, int n)
  {
    for_each(n, Rule{m});
  }

  template <class F, class T>
  void for_each_to_host(int n, const F& f, T* to)
  {
    for_each(n, [&f, to](int i) { to[i] = f(i); });
  }
  template <class F, class T>
  void for_each_from_host(int n, const F& f, const T* from)
  {
    for_each(n, [&f, from](int i) { f(i, from[i]); });
  }

  /** A rule on the cells of a rectangle of the window. */
  template <class Rule>
  void for_each_cell(const kernels::Map& m, const WindowRect& cells)
  {
    for_each_row(
        cells.width, cells.height,
        [&](int y)
        { StoredRow(m, cells.first_y + y).run<Rule>(cells.first_x, cells.first_x + cells.width); });
  }
  /** Rules on all cells of the window, row by row. */
  template <class... Rules>
  void for_each_cell(const kernels::Map& m)
  {
    for_each_row(
        m.k.cells, m.k.cells,
        [&](int y)
        {
          const StoredRow row(m, y);
          (row.run<Rules>(), ...);
        });
  }

  template <class F>
  void for_each_row(int nx, int ny, const F& f)
  {
    for_each(ny, f, rows_at_once(nx));
  }
  template <class F>
  void for_each_stretch(const kernels::Map& m, int n)
  {
    run(n, 128, [&m](int begin, int end) { over_stretch<F>(m, begin, end); });
  }
  template <class F>
  void locate_points(const kernels::Map& m, int n)
  {
    run(n, 1024, [&m](int begin, int end) { over_points<F>(m, begin, end); });
  }
  /** f(i) for points in order; each thread those of its part, see f.is_in(). */
  template <class F>
  void for_each_point_by_parts(const kernels::Map& m, int n)
  {
    const int parts = n <= kFewPoints ? 1 : threads_.size();
    if (parts == 1)
      one_by_one<F>(m, n);
    else
      for_each_part(parts, [&m, n, parts](int part) { over_own_points<F>(m, n, part, parts); });
  }
  template <class F>
  void for_each_window(const kernels::Map& m, int nx, int ny, int radius)
  {
    run(ny, std::max(8 * radius, rows_at_once(nx)),
        [&](int begin, int end) { SlidingRows<F>(m, nx, ny, radius).run(begin, end); });
  }

  template <class T>
  void fill(Buffer<T>& buffer, T value)
  {
    run(static_cast<int>(buffer.size()), 1 << 14,
        [to = buffer.data(), value](int begin, int end) { fill_with(to, begin, end, value); });
  }

  int threads() const { return threads_.size(); }
  /** Whether one thread is faster for so few points than several that exchange cache lines. */
  bool is_small(int n) const { return n <= kFewPoints && threads_.size() > 1; }
  static int rows_at_once(int nx) { return std::max(1, 4096 / std::max(nx, 1)); }

  template <class F>
  [[gnu::flatten]] static void one_by_one(const kernels::Map& map, int n)
  {
    const kernels::Map m = map;
    const F f{m};
    for (int i = 0; i < n; i++) f(i);
  }
  /** f(i) for i in [0, n), each long enough for a thread. */
  template <class F>
  void for_each_part(int n, const F& f)
  {
    for_each(n, f, 1);
  }
  template <class Body>
  void run(int n, int grain, const Body& body)
  {
    threads_.run(n, grain, body);
  }
  /** Runs `body` as run() does, while one thread runs `first`, which must not run loops. */
  template <class First, class Body>
  void run_beside(const First& first, int n, int grain, const Body& body)
  {
    run((n + grain - 1) / grain + 1, 1,
        [&](int begin, int end)
        {
          if (begin == 0) first();
          begin = std::max(begin - 1, 0) * grain, end = std::min((end - 1) * grain, n);
          if (begin < end) body(begin, end);
        });
  }

 private:
  static constexpr int kFewPoints = 1 << 15;
  Threads threads_;
};

}  // namespace talus
