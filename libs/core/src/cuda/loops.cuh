#pragma once
#include "kernels/7_traversability.h"
#include "kernels/group.h"
#include "kernels/map.h"

#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

// The loops of the CUDA executor as kernels. Each has the rule for one point, cell or bit as a
// type, takes the map by value, and leaves its end time in `done_ns`.

namespace talus::loops
{
constexpr int kThreads = 256;  //!< max of a block over a range
constexpr int kTileWidth = 32, kTileRows = 8;  //!< max of a block over cells
// Min blocks of a multiprocessor, which bound the registers. For blocks over bits, since the one
// warp that does more must not take the registers of the others.
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ < 800
constexpr int kTilesAtOnce = 4, kBitBlocksAtOnce = 4;
#else
constexpr int kTilesAtOnce = 5, kBitBlocksAtOnce = 6;
#endif
constexpr int kHandedOver = 64;  //!< of a block that hands over records
constexpr int kWindowThreads = 16;  //!< rows of a block with neighbourhoods
constexpr int kJudgedRows = 2 * kWindowThreads;  //!< max of a tile that overlaps with others
constexpr int kMaxRows = 43;  //!< max that such a tile sums, to fit into shared memory

/** With programmatic dependent launch a kernel is brought up while its predecessor still runs. This
 * waits for the predecessor's results, then lets the successor come up. */
__device__ inline void wait_for_predecessor()
{
#if __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
  cudaTriggerProgrammaticLaunchCompletion();
#endif
}

/** wait_for_predecessor() for a kernel that may run beside its predecessor, as it needs nothing of
 * it. Its end waits for the predecessor, so that waiting for this one is waiting for both. */
__device__ inline void start(bool beside_last)
{
  if (!beside_last)
    wait_for_predecessor();
  else
  {
#if __CUDA_ARCH__ >= 900
    cudaTriggerProgrammaticLaunchCompletion();
#endif
  }
}
__device__ inline void finish(bool beside_last)
{
#if __CUDA_ARCH__ >= 900
  if (beside_last) cudaGridDependencySynchronize();
#endif
}

__device__ inline void note_time(std::uint64_t* done_ns)
{
  const bool last = blockIdx.x == gridDim.x - 1 && blockIdx.y == gridDim.y - 1;
  if (!done_ns || !last || threadIdx.x || threadIdx.y) return;
  asm volatile("mov.u64 %0, %%globaltimer;" : "=l"(*done_ns));
}

template <class F>
__global__ void __launch_bounds__(kThreads)
    over_range(int n, const __grid_constant__ kernels::Map m, std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < n) F{m}(i);
  note_time(done_ns);
}
template <class T>
__global__ void __launch_bounds__(kThreads) fill_with(int n, T* to, T value, std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < n) to[i] = value;
  note_time(done_ns);
}

/** to[i] = f(i), in host memory. A block sends word after word, which suits the bus best. */
template <class F, class T>
__global__ void __launch_bounds__(kHandedOver) to_host(int n, F f, T* to, std::uint64_t* done_ns)
{
  constexpr int kWords = sizeof(T) / sizeof(std::uint32_t);
  static_assert(sizeof(T) == kWords * sizeof(std::uint32_t));
  __shared__ std::uint32_t words[kHandedOver * kWords];
  wait_for_predecessor();
  const int thread = static_cast<int>(threadIdx.x);
  const int first = static_cast<int>(blockIdx.x) * kHandedOver;
  if (first + thread < n)
  {
    const T value = f(first + thread);
    std::memcpy(words + thread * kWords, &value, sizeof value);
  }
  __syncthreads();
  auto* const out = reinterpret_cast<std::uint32_t*>(to + first);
  for (int w = thread; w < min(n - first, kHandedOver) * kWords; w += kHandedOver)
    out[w] = words[w];
  note_time(done_ns);
}

/** f(i, from[i]), from host memory in the same way. */
template <class F, class T>
__global__ void __launch_bounds__(kHandedOver)
    from_host(int n, F f, const T* from, std::uint64_t* done_ns)
{
  constexpr int kWords = sizeof(T) / sizeof(std::uint32_t);
  static_assert(sizeof(T) == kWords * sizeof(std::uint32_t));
  __shared__ std::uint32_t words[kHandedOver * kWords];
  wait_for_predecessor();
  const int thread = static_cast<int>(threadIdx.x);
  const int first = static_cast<int>(blockIdx.x) * kHandedOver;
  const auto* const in = reinterpret_cast<const std::uint32_t*>(from + first);
  for (int w = thread; w < min(n - first, kHandedOver) * kWords; w += kHandedOver) words[w] = in[w];
  __syncthreads();
  if (first + thread < n)
  {
    T value;
    std::memcpy(&value, words + thread * kWords, sizeof value);
    f(first + thread, value);
  }
  note_time(done_ns);
}

/** f.update() of crowded cells, a warp each, which takes the next one; then a thread a cell. */
template <class F>
__global__ void __launch_bounds__(kThreads) over_range_and_groups(
    int n, int groups, const __grid_constant__ kernels::Map m, std::uint64_t* done_ns)
{
  const F f{m};
  wait_for_predecessor();
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  const bool is_group = i < 32 * groups;
  int slot = i / 32;
  int cell = is_group              ? f.crowded_cell(slot)
             : i - 32 * groups < n ? f.lone_cell(i - 32 * groups)
                                   : -1;
  while (cell >= 0)
  {
    f.update(cell, kernels::WarpGroup{is_group});
    cell = is_group ? f.crowded_cell(slot += groups) : -1;
  }
  note_time(done_ns);
}

template <class F>
__global__ void __launch_bounds__(kTileWidth* kTileRows, kTilesAtOnce) over_cells(
    int x_first, int x_end, int y_first, int y_end, const __grid_constant__ kernels::Map m,
    bool beside_last, std::uint64_t* done_ns)
{
  start(beside_last);
  const int x = x_first + static_cast<int>(blockIdx.x * kTileWidth + threadIdx.x);
  const int y = y_first + static_cast<int>(blockIdx.y * blockDim.y + threadIdx.y);
  if (x < x_end && y < y_end) kernels::apply<F>(m, x, y);
  finish(beside_last);
  note_time(done_ns);
}

/** Sums of a block's columns along the rows [first, last), in shared memory. */
template <class F>
__device__ void sum_rows(const F& f, int x, int first, int last, int radius, typename F::Row* rows)
{
  for (int y = first + static_cast<int>(threadIdx.y); y < last; y += kWindowThreads)
  {
    typename F::Row sum;
#pragma unroll 8
    for (int d = -radius; d <= radius; d++) f.add(sum, x, y, d);
    rows[(y - first) * kTileWidth] = sum;
  }
}

/** Adds them up over the neighbourhood of a cell of row y. */
template <class F>
__device__ typename F::Window sum_window(
    const F& f, int y, int first, int last, int radius, const typename F::Row* rows)
{
  typename F::Window sum;
  for (int row = max(y - radius, first); row < min(y + radius + 1, last); row++)
    f.add(sum, rows[(row - first) * kTileWidth], row - y);
  return sum;
}

/** f for square neighbourhoods: sums along the rows of a tile are in shared memory. */
template <class F>
__global__ void __launch_bounds__(kTileWidth* kWindowThreads) over_windows(
    int nx, int ny, int radius, int height, const __grid_constant__ kernels::Map m,
    std::uint64_t* done_ns)
{
  const F f{m};
  extern __shared__ __align__(16) unsigned char shared[];
  auto* const rows = reinterpret_cast<typename F::Row*>(shared) + threadIdx.x;
  wait_for_predecessor();
  const int x = static_cast<int>(blockIdx.x) * kTileWidth + static_cast<int>(threadIdx.x);
  const int y0 = static_cast<int>(blockIdx.y) * height, y1 = min(y0 + height, ny);
  const int first = max(y0 - radius, 0), last = min(y1 + radius, ny);
  if (x < nx) sum_rows(f, x, first, last, radius, rows);
  __syncthreads();
  if (x < nx)
    for (int y = y0 + static_cast<int>(threadIdx.y); y < y1; y += kWindowThreads)
      f(x, y, sum_window(f, y, first, last, radius, rows));
  note_time(done_ns);
}

/** Sums over square neighbourhoods, for the rows [y_first, y_end) of ny. Sums along the rows of a
 * tile of `height` rows go to shared memory, sums across them to f.judge(). Then g.complete() gets
 * the results of a cell and its eight neighbours: tiles overlap by a cell on each side. */
template <class F, class G>
__global__ void __launch_bounds__(kTileWidth* kWindowThreads) over_windows_and_neighbours(
    int nx, int ny, int y_first, int y_end, int radius, int height,
    const __grid_constant__ kernels::Map m, bool beside_last, std::uint64_t* done_ns)
{
  const F f{m};
  extern __shared__ __align__(16) unsigned char shared[];
  __shared__ float judged[kJudgedRows][kTileWidth];
  __shared__ std::uint8_t passability[kJudgedRows][kTileWidth];
  auto* const rows = reinterpret_cast<typename F::Row*>(shared) + threadIdx.x;
  start(beside_last);
  const int lane = static_cast<int>(threadIdx.x), line = static_cast<int>(threadIdx.y);
  const int x = static_cast<int>(blockIdx.x) * (kTileWidth - 2) + lane - 1;
  const int y0 = y_first + static_cast<int>(blockIdx.y) * height, y1 = min(y0 + height, y_end);
  const int first = max(y0 - 1 - radius, 0), last = min(y1 + 1 + radius, ny);
  const bool exists = x >= 0 && x < nx, own = exists && lane > 0 && lane < kTileWidth - 1;
  if (exists) sum_rows(f, x, first, last, radius, rows);
  __syncthreads();
  if (exists)
    for (int y = max(y0 - 1, 0) + line; y < min(y1 + 1, ny); y += kWindowThreads)
    {
      const kernels::Judgement j =
          f.judge(x, y, sum_window(f, y, first, last, radius, rows), own && y >= y0 && y < y1);
      judged[y - y0 + 1][lane] = j.score;
      passability[y - y0 + 1][lane] = static_cast<std::uint8_t>(j.passability);
    }
  __syncthreads();
  if (own)
    for (int y = y0 + line; y < y1; y += kWindowThreads)
      G{m}.complete(x, y, {&passability[y - y0 + 1][lane], kTileWidth}, judged[y - y0 + 1][lane]);
  finish(beside_last);
  note_time(done_ns);
}

/** The tiles of a grid of cells as blocks of one dimension, after those of a range. */
struct Tiles
{
  int columns;
  float inverse_columns;

  /** A rule on the thread's cell of nx * ny, with blocks of one dimension. */
  template <class Rule>
  __device__ void run(int block, int nx, int ny, const kernels::Map& m) const
  {
    const int row = kernels::floor_div(block, columns, inverse_columns);
    const int column = block - row * columns, rows = static_cast<int>(blockDim.x) / kTileWidth;
    const int x = column * kTileWidth + static_cast<int>(threadIdx.x) % kTileWidth;
    const int y = row * rows + static_cast<int>(threadIdx.x) / kTileWidth;
    if (x < nx && y < ny) kernels::apply<Rule>(m, x, y);
  }
};

/** The data that f may read of element i before its predecessor ends. */
template <class F, class = void>
struct Early
{
  __device__ void read(const F&, int) {}
  __device__ void run(const F& f, int i) const { f(i); }
};
template <class F>
struct Early<F, std::void_t<decltype(&F::early)>>
{
  decltype(std::declval<F>().early(0)) value{};
  __device__ void read(const F& f, int i) { value = f.early(i); }
  __device__ void run(const F& f, int i) const { f(i, value); }
};

/** Elements of two kinds in one range. */
template <class First, class Then>
struct Both
{
  Early<First> first;
  Early<Then> then;

  __device__ void read(const kernels::Map& m, int firsts, int i)
  {
    if (i < firsts)
      first.read(First{m}, i);
    else
      then.read(Then{m}, i - firsts);
  }
  __device__ void run(const kernels::Map& m, int firsts, int i) const
  {
    if (i < firsts)
      first.run(First{m}, i);
    else
      then.run(Then{m}, i - firsts);
  }
};

template <class First, class Then, class Cells>
__global__ void __launch_bounds__(kThreads) over_range_and_cells(
    int firsts, int n, int nx, int ny, Tiles tiles, const __grid_constant__ kernels::Map m,
    std::uint64_t* done_ns)
{
  const int size = static_cast<int>(blockDim.x), range = (n + size - 1) / size;
  const int block = static_cast<int>(blockIdx.x) - range;
  const int i = static_cast<int>(blockIdx.x) * size + static_cast<int>(threadIdx.x);
  Both<First, Then> both;
  if (i < n) both.read(m, firsts, i);
  wait_for_predecessor();
  if (block >= 0)
    tiles.template run<Cells>(block, nx, ny, m);
  else if (i < n)
    both.run(m, firsts, i);
  note_time(done_ns);
}

constexpr int kStretches = 32;  //!< of a direction, one for each lane of a warp
constexpr int kDirections = 8;  //!< of a block: one sector of memory

template <class T>
__device__ T from_lane(const T& v, int lane)
{
  static_assert(sizeof(T) % 4 == 0);
  int words[sizeof(T) / 4];
  memcpy(words, &v, sizeof(T));
  for (int& word : words) word = __shfl_sync(0xffffffffu, word, lane);
  T out;
  memcpy(&out, words, sizeof(T));
  return out;
}

/** The sum of the lanes before this one; v is empty at first. */
template <class T>
__device__ T sum_before(T v)
{
  const int lane = static_cast<int>(threadIdx.x) % 32;
  for (int step = 1; step < 32; step *= 2)
  {
    const T other = from_lane(v, max(lane - step, 0));
    if (lane >= step) v.add(other);
  }
  const T before = from_lane(v, max(lane - 1, 0));
  return lane ? before : T{};
}

/** For each range of the block's directions, the sum of the ranges before it. */
template <class T>
__device__ T sum_before_stretch(const T& own, T (*shared)[kStretches + 1], int at, int direction)
{
  const int warp = static_cast<int>(threadIdx.x) / 32, lane = static_cast<int>(threadIdx.x) % 32;
  shared[direction][at] = own;
  __syncthreads();
  shared[warp][lane] = sum_before(shared[warp][lane]);
  __syncthreads();
  return shared[direction][at];
}

/** The three steps of f on a block's directions, see kernels::SettleRays. */
template <class F>
__device__ void over_directions(int block, int directions, const F& f)
{
  using Before = typename F::Before;
  using Behind = typename F::Behind;
  __shared__ Before before[kDirections][kStretches + 1];
  __shared__ Behind behind[kDirections][kStretches + 1];
  const int column = static_cast<int>(threadIdx.x) % kDirections;
  const int stretch = static_cast<int>(threadIdx.x) / kDirections;
  const int direction = block * kDirections + column;
  const int rings = f.rings();
  const int length = direction < directions ? (rings + kStretches - 1) / kStretches : 0;
  const int begin = stretch * length, end = min(begin + length, rings);
  Before seen;
  f.collect(direction, begin, end, seen);
  seen = sum_before_stretch(seen, before, stretch, column);
  Behind lowest;
  f.bury(direction, begin, end, seen, lowest);
  lowest = sum_before_stretch(lowest, behind, kStretches - 1 - stretch, column);
  f.sweep(direction, begin, end, lowest);
}

/** The directions first, for they take longer; h(group) has a block of its own. */
template <class F, class First, class Then, class H>
__global__ void __launch_bounds__(kThreads) over_directions_and_range(
    int directions, int firsts, int n, const __grid_constant__ kernels::Map m,
    std::uint64_t* done_ns)
{
  static_assert(kThreads == kStretches * kDirections);
  wait_for_predecessor();
  const int first = (directions + kDirections - 1) / kDirections;
  const int block = static_cast<int>(blockIdx.x), thread = static_cast<int>(threadIdx.x);
  const int i = (block - first - 1) * kThreads + thread;
  if (block < first)
    over_directions(block, directions, F{m});
  else if (block == first && thread < 32)
    H{m}(kernels::WarpGroup{true});
  else if (block > first && i < n)
    Both<First, Then>().run(m, firsts, i);
  note_time(done_ns);
}

/** F{m}(line, bit) for all bits as words, [word][line]. A warp makes several words of a line. */
template <class F>
__global__ void __launch_bounds__(kThreads, kBitBlocksAtOnce) over_bits(
    int lines, int bits, const __grid_constant__ kernels::Map m, std::uint32_t* words,
    std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int line = static_cast<int>(blockIdx.x * kThreads + threadIdx.x) / 32;
  const int lane = static_cast<int>(threadIdx.x) % 32;
  if (line < lines)
  {
    for (int word = static_cast<int>(blockIdx.y); 32 * word < bits;
         word += static_cast<int>(gridDim.y))
    {
      const int bit = 32 * word + lane;
      const unsigned packed = __ballot_sync(0xffffffffu, bit < bits && F{m}(line, bit));
      if (lane == 0) words[word * lines + line] = packed;
    }
  }
  note_time(done_ns);
}

/** f.begin(x, y) for the cells; f.inspect(x, y) where that is true, a warp each, as it is long and
 * rare; then f(x, y), whose marks are written for rows, then for columns, as [word][line]. */
template <class F>
__global__ void __launch_bounds__(kTileWidth* kTileRows) over_marked_cells(
    int side, const __grid_constant__ kernels::Map m, std::uint32_t* marks, std::uint64_t* done_ns)
{
  const F f{m};
  wait_for_predecessor();
  __shared__ unsigned rows[kTileRows];
  constexpr int kCells = kTileRows * kTileWidth;
  __shared__ int wanting[kCells], n_wanting;
  const int lane = static_cast<int>(threadIdx.x), row = static_cast<int>(threadIdx.y);
  const int word = static_cast<int>(blockIdx.x), x0 = kTileWidth * word, x = x0 + lane;
  const int y0 = static_cast<int>(blockIdx.y) * kTileRows, y = y0 + row;
  const bool inside = x < side && y < side;
  if (lane + row == 0) n_wanting = 0;
  __syncthreads();
  if (inside && f.begin(x, y)) wanting[atomicAdd(&n_wanting, 1)] = row * kTileWidth + lane;
  __syncthreads();
  for (int w = row; w < n_wanting; w += kTileRows)
    f.inspect(x0 + wanting[w] % kTileWidth, y0 + wanting[w] / kTileWidth, kernels::WarpGroup{true});
  __syncthreads();
  const unsigned marked = __ballot_sync(0xffffffffu, inside && f(x, y));
  if (lane == 0) rows[row] = marked;
  if (lane == 0 && y < side) marks[word * 2 * side + y] = marked;
  __syncthreads();
  if (row == 0 && x < side)
  {
    unsigned column = 0;
    for (int r = 0; r < kTileRows; r++) column |= (rows[r] >> lane & 1u) << r;
    std::uint32_t* const of_column = marks + y0 / 32 * 2 * side + side + x;
    reinterpret_cast<std::uint8_t*>(of_column)[y0 % 32 / 8] = static_cast<std::uint8_t>(column);
  }
  note_time(done_ns);
}

/** f.side() and f.behind(), a thread each, then f.line(), then f for the cell. */
template <class F>
__global__ void __launch_bounds__((2 * F::kLines + 1) * 32) over_cells_by_lines(
    int nx, int y0, const __grid_constant__ kernels::Map m, std::uint64_t* done_ns)
{
  const F f{m};
  __shared__ typename F::Behind behind[32];
  __shared__ typename F::Side sides[2 * F::kLines][32];
  __shared__ typename F::Line lines[F::kLines][32];
  wait_for_predecessor();
  const int lane = static_cast<int>(threadIdx.x), part = static_cast<int>(threadIdx.y);
  const int x = static_cast<int>(blockIdx.x) * 32 + lane, y = y0 + static_cast<int>(blockIdx.y);
  if (x < nx && part < 2 * F::kLines)
    sides[part][lane] = f.side(part / 2, part % 2 == 1, x, y);
  else if (x < nx)
    behind[lane] = f.behind(x, y);
  __syncthreads();
  if (x < nx && part < F::kLines)
    lines[part][lane] = f.line(sides[2 * part][lane], sides[2 * part + 1][lane]);
  __syncthreads();
  if (x < nx && part == 0)
    f(x, y, sides[0][lane], sides[1][lane], behind[lane], &lines[0][lane], 32);
  note_time(done_ns);
}

__global__ void __launch_bounds__(kThreads)
    fetch(int n, const std::uint32_t* from, std::uint32_t* to, std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < n) to[i] = from[i];
  note_time(done_ns);
}

}  // namespace talus::loops
