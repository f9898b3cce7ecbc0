#pragma once
#include "backend.h"
#include "cpu_buffer.h"
#include "cpu_lines.h"
#include "cpu_loops.h"
#include "kernels/1_accept.h"
#include "kernels/team.h"

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
  using Buffer = std::vector<T, CellMemory<T>>;

  /** Cells of more points are updated by a team of threads: all, each by a team of one. */
  static constexpr int kCrowd = 0;
  /** Fills sweep along lines and carry samples with them. */
  static constexpr bool kWalksLines = true;

  template <class T>
  void allocate(Buffer<T>& buffer, std::size_t size, T value)
  {
    buffer.assign(size, value);
  }
  template <class T>
  void upload(const T* from, std::size_t size, T* to)
  {
    copy(to, from, size);
  }
  template <class T>
  void download(const T* from, std::size_t size, T* to)
  {
    copy(to, from, size);
  }
  template <class T>
  void copy(T* to, const T* from, std::size_t size)
  {
    std::copy_n(from, size, to);
  }
  void synchronize() {}

  OutputMemory map_output(float* host, std::size_t) { return {true, host}; }
  void forget_outputs() {}

  std::string name() const { return "cpu"; }

  // ---- one frame, of the slot in use ----
  void use(int slot) { now_ = static_cast<std::size_t>(slot); }
  int loop_size(int points, std::size_t) const { return points; }
  /** How many calls should share work on that many elements. */
  int workers(int) const { return 1; }
  PointArrays point_arrays(std::size_t capacity)
  {
    slots_[now_].points.resize(4 * capacity);
    float* p = slots_[now_].points.data();
    return {p, p + capacity, p + 2 * capacity, p + 3 * capacity};
  }
  /** The points stay in the caller's own memory. */
  kernels::PointsIn stage(const Frame& f, const kernels::FrameContext& context, std::size_t)
  {
    slots_[now_].context = &context;
    return {f.x_m, f.y_m, f.z_m, f.time_s};
  }
  /** All is done in the end. */
  template <class Body>
  void start_frame(const Body&)
  {
  }
  template <class Body>
  void finish_frame(const Body& body)
  {
    start_ = last_ = Clock::now();
    stage_ms_ = {};
    body();
  }
  void fetch(Buffer<kernels::FrameContext>& context) { context.assign(1, *slots_[now_].context); }
  /** Where a frame leaves its counters for the host. */
  std::uint32_t* reported() { return counters_.data(); }
  void join() {}
  /** The time since the last lap belongs to a stage. */
  void lap(int stage)
  {
    const auto now = Clock::now();
    stage_ms_[static_cast<std::size_t>(stage)] += milliseconds(std::exchange(last_, now), now);
  }
  /** The time that `body` takes belongs to a stage other than the current one. */
  template <class Body>
  void for_another_stage(int stage, const Body& body)
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
    std::vector<float> points;  //!< of point_arrays()
  };
  std::array<Slot, kSlots> slots_;
  std::size_t now_ = 0;
  std::array<std::uint32_t, kernels::kRejectCodes> counters_{};
};

/** All work on the calling thread. */
struct OneThread
{
  using Atomics = kernels::SerialAtomics;
  template <class Body>
  void run(int n, int, const Body& body) const
  {
    if (n > 0) body(0, n);
  }
};

#if defined(TALUS_HAVE_TBB)
/** oneTBB threads. */
class ThreadPool
{
 public:
  using Atomics = kernels::ThreadAtomics;
  explicit ThreadPool(int threads) : arena_(std::make_unique<tbb::task_arena>(threads)) {}

  /** body(begin, end) of pieces of [0, n), of `grain` and more. */
  template <class Body>
  void run(int n, int grain, const Body& body) const
  {
    arena_->execute(
        [&]
        {
          tbb::parallel_for(
              tbb::blocked_range<int>(0, n, static_cast<std::size_t>(grain)),
              [&](const tbb::blocked_range<int>& r) { body(r.begin(), r.end()); });
        });
  }

 private:
  std::unique_ptr<tbb::task_arena> arena_;
};
#endif

/** Runs the stages' loops. An executor supplies buffers, loops and the atomics that its threads
 * need; it knows nothing of the map. */
template <class Threads>
class CpuExecutor : public CpuMemory
{
 public:
  using Atomics = typename Threads::Atomics;
  explicit CpuExecutor(Threads threads) : threads_(std::move(threads)) {}

  /** f(i) for i in [0, n) */
  template <class F>
  void for_each(int n, const F& f)
  {
    run(n, 1024,
        [&f](int begin, int end)
        {
          for (int i = begin; i < end; i++) f(i);
        });
  }

  /** f(x, y) for x in [0, nx), y in [0, ny) */
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

  /** f(y) for y in [0, ny), rows of nx cells. */
  template <class F>
  void for_each_row(int nx, int ny, const F& f)
  {
    run(ny, std::max(1, 4096 / std::max(nx, 1)),
        [&f](int begin, int end)
        {
          for (int y = begin; y < end; y++) f(y);
        });
  }
  /** f(begin, end) of stretches of [0, n). */
  template <class F>
  void for_each_stretch(int n, const F& f)
  {
    run(n, 128, [&f](int begin, int end) { over_stretch(f, begin, end); });
  }
  /** f of points in two phases. */
  template <class F>
  void for_each_point(int n, const F& f)
  {
    run(n, 1024, [&f](int begin, int end) { over_points(f, begin, end); });
  }
  /** f.put(i, f.overhangs(i)) of points. */
  template <class F>
  void sort_points(int n, const F& f)
  {
    run(n, 1024, [&f](int begin, int end) { talus::sort_points(f, begin, end); });
  }
  /** f(x, y, i) of the cells of the window with i where each is stored. */
  template <class F>
  void for_each_stored_cell(int cells, const kernels::FrameContext* frame, const F& f)
  {
    for_each_stored_stretch(
        cells, *frame, [&f](int begin, int end, int y, int i) { over_row(f, begin, end, y, i); });
  }
  /** The same of those that f.concerns(x, y, i). */
  template <class F>
  void for_each_concerned_cell(int cells, const kernels::FrameContext* frame, const F& f)
  {
    for_each_stored_stretch(
        cells, *frame,
        [&f](int begin, int end, int y, int i) { over_concerned(f, begin, end, y, i); });
  }
  /** f(i) for i in [0, n); beside it, for another stage, g(x, y, i) of the cells that it concerns.
   */
  template <class F, class G>
  void for_each_concerned_cell_beside(
      int n, const F& f, int stage, int cells, const kernels::FrameContext* frame, const G& g)
  {
    for_each(n, f);
    for_another_stage(stage, [&] { for_each_concerned_cell(cells, frame, g); });
  }
  /** f in steps of the cells of the window, see SteppedRow. */
  template <class F>
  void for_each_cell_in_steps(int cells, const kernels::FrameContext* frame, const F& f)
  {
    for_each_stored_stretch(
        cells, *frame,
        [&f](int begin, int end, int y, int i) { SteppedRow<F>(f).run(begin, end, y, i); });
  }

  /** f.put(px, py, pooled) of pairs of pairs of cells, `n` along each side, see PairOfRows. */
  template <class F>
  void for_each_pair_of_rows(int n, int cells, const kernels::FrameContext* frame, const F& f)
  {
    for_each_row(
        2 * n, n, [&f, cells, frame, n](int py) { PairOfRows<F>(f, n).pool(py, cells, *frame); });
  }

  /** Fills `to` by sweeping along the rays from the sensor's cell, then rows, then columns. */
  void walk_lines(
      const kernels::Config& k, const kernels::LineGrid& grid, const kernels::Samples& samples,
      const kernels::InferenceGrid& to)
  {
    const lines::Walk walk{k, grid, samples, to};
    for_each_part(walk.parts_of_rays(), [&walk](int part) { walk.rays(part); });
    if (k.fill_rule != kernels::kFillLines) return;
    for_each_part(walk.parts_of_axis(), [&walk](int part) { walk.rows(part); });
    for_each_part(walk.parts_of_axis(), [&walk](int part) { walk.columns(part); });
  }

  /** f(i, team) for i in [0, teams). */
  template <class F>
  void for_each_and_team(int, int teams, const F& f)
  {
    for_each(teams, [&f](int i) { f(i, kernels::LoneTeam{}); });
  }

  /** Sums over square neighbourhoods of the cells, see SlidingRows. */
  template <class F>
  void for_each_window(int nx, int ny, int radius, const F& f)
  {
    run(ny, std::max(8 * radius, 4096 / std::max(nx, 1)),
        [&](int begin, int end) { SlidingRows<F>(nx, ny, radius, f).run(begin, end); });
  }

  template <class T>
  void fill(Buffer<T>& buffer, T value)
  {
    run(static_cast<int>(buffer.size()), 1 << 14,
        [&](int begin, int end)
        { std::fill(buffer.begin() + begin, buffer.begin() + end, value); });
  }

 private:
  /** over(begin, end, y, i) of the rows of the window, see over_stored_row(). */
  template <class Over>
  void for_each_stored_stretch(int cells, const kernels::FrameContext& frame, const Over& over)
  {
    for_each_row(
        cells, cells,
        [&over, &frame, cells](int y)
        {
          over_stored_row(
              [&over, y](int begin, int end, int i) { over(begin, end, y, i); }, cells, frame, y);
        });
  }
  /** f(i) for i in [0, n), each of them work enough for a thread. */
  template <class F>
  void for_each_part(int n, const F& f)
  {
    run(n, 1,
        [&f](int begin, int end)
        {
          for (int i = begin; i < end; i++) f(i);
        });
  }
  template <class Body>
  void run(int n, int grain, const Body& body) const
  {
    threads_.run(n, grain, body);
  }
  Threads threads_;
};

}  // namespace talus
