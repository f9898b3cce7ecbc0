#pragma once
#include "kernels/cell.h"
#include "kernels/team.h"

#include <cstdint>

// The loops of the CUDA executor as kernels. Each takes the rule for one point, cell or bit by
// value and leaves the time at which it finished in `done_ns`.

namespace talus::loops
{
constexpr int kThreads = 256;  //!< of a block over a range, at most
constexpr int kTileWidth = 32, kTileRows = 8;  //!< threads of a block over cells
constexpr int kWindowThreads = 16;  //!< rows of threads of a block with neighbourhoods

/** Where kernels are chained (programmatic dependent launch), a kernel is brought up while its
 * predecessor still runs: waits for its results, then lets the successor come up. */
__device__ inline void wait_for_predecessor()
{
#if __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
  cudaTriggerProgrammaticLaunchCompletion();
#endif
}

/** The last block notes when it is done. */
__device__ inline void note_time(std::uint64_t* done_ns)
{
  const bool last = blockIdx.x == gridDim.x - 1 && blockIdx.y == gridDim.y - 1;
  if (!done_ns || !last || threadIdx.x || threadIdx.y) return;
  asm volatile("mov.u64 %0, %%globaltimer;" : "=l"(*done_ns));
}

template <class F>
__global__ void __launch_bounds__(kThreads) over_range(int n, F f, std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < n) f(i);
  note_time(done_ns);
}

/** First the teams, a warp each, since theirs is the longer work. */
template <class F>
__global__ void __launch_bounds__(kThreads)
    over_range_and_teams(int n, int teams, F f, std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int i = static_cast<int>(blockIdx.x * kThreads + threadIdx.x);
  if (i < 32 * teams)
    f(i / 32, kernels::WarpTeam{});
  else if (i - 32 * teams < n)
    f(i - 32 * teams);
  note_time(done_ns);
}

template <class F>
__global__ void __launch_bounds__(kTileWidth* kTileRows)
    over_cells(int nx, int ny, F f, std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int x = static_cast<int>(blockIdx.x) * kTileWidth + static_cast<int>(threadIdx.x);
  const int y = static_cast<int>(blockIdx.y) * kTileRows + static_cast<int>(threadIdx.y);
  if (x < nx && y < ny) f(x, y);
  note_time(done_ns);
}

/** Sums over square neighbourhoods: those along all rows that a tile of `height` rows needs go to
 * shared memory, then those across them to f() of its cells. */
template <class F>
__global__ void __launch_bounds__(kTileWidth* kWindowThreads)
    over_windows(int nx, int ny, int radius, int height, F f, std::uint64_t* done_ns)
{
  using Row = typename F::Row;
  using Window = typename F::Window;
  extern __shared__ __align__(16) unsigned char shared[];
  Row* const rows = reinterpret_cast<Row*>(shared) + threadIdx.x;
  wait_for_predecessor();
  const int x = static_cast<int>(blockIdx.x) * kTileWidth + static_cast<int>(threadIdx.x);
  const int y0 = static_cast<int>(blockIdx.y) * height;
  const int first = max(y0 - radius, 0), last = min(y0 + height + radius, ny);
  if (x < nx)
    for (int y = first + static_cast<int>(threadIdx.y); y < last; y += kWindowThreads)
    {
      Row sum;
#pragma unroll 8
      for (int d = -radius; d <= radius; d++) f.add(sum, x, y, d);
      rows[(y - first) * kTileWidth] = sum;
    }
  __syncthreads();
  if (x < nx)
    for (int y = y0 + static_cast<int>(threadIdx.y); y < min(y0 + height, ny); y += kWindowThreads)
    {
      Window sum;
      for (int row = max(y - radius, first); row < min(y + radius + 1, last); row++)
        f.add(sum, rows[(row - first) * kTileWidth], row - y);
      f(x, y, sum);
      f.finish(x, y, [&] { return sum; });
    }
  note_time(done_ns);
}

template <class F, class G>
__global__ void __launch_bounds__(kThreads)
    over_range_and_cells(int n, F f, int nx, int ny, G g, std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int size = static_cast<int>(blockDim.x), range = (n + size - 1) / size;
  const int block = static_cast<int>(blockIdx.x) - range;
  if (block < 0)
  {
    const int i = static_cast<int>(blockIdx.x) * size + static_cast<int>(threadIdx.x);
    if (i < n) f(i);
  }
  else
  {
    const int columns = (nx + kTileWidth - 1) / kTileWidth, rows = size / kTileWidth;
    const int x = block % columns * kTileWidth + static_cast<int>(threadIdx.x) % kTileWidth;
    const int y = block / columns * rows + static_cast<int>(threadIdx.x) / kTileWidth;
    if (x < nx && y < ny) g(x, y);
  }
  note_time(done_ns);
}

/** f(x, y, i), i where the cell of the window is stored, of the cells that it concerns. */
template <class F>
struct OfConcernedCells
{
  int cells;
  const kernels::FrameContext* frame;
  F f;
  __device__ void operator()(int x, int y) const
  {
    const int i = kernels::storage_index(*frame, cells, x, y);
    if (f.concerns(x, y, i)) f(x, y, i);
  }
};

/** One warp makes one word: lane b asks for bit b. */
template <class F>
__device__ void pack_word(int lines, int bits, const F& f, std::uint32_t* words, int warp)
{
  const int line = warp % lines, word = warp / lines;
  const int bit = 32 * word + static_cast<int>(threadIdx.x) % 32;
  const unsigned packed = __ballot_sync(0xffffffffu, bit < bits && f(line)(bit));
  if (threadIdx.x % 32 == 0) words[warp] = packed;
}

template <class F, class G>
__global__ void __launch_bounds__(kThreads) over_bits(
    int lines, int bits, F f, std::uint32_t* words, int more_lines, int more_bits, G g,
    std::uint32_t* more_words, std::uint64_t* done_ns)
{
  wait_for_predecessor();
  const int warp = static_cast<int>(blockIdx.x * kThreads + threadIdx.x) / 32;
  const int first = lines * ((bits + 31) / 32), second = more_lines * ((more_bits + 31) / 32);
  if (warp < first)
    pack_word(lines, bits, f, words, warp);
  else if (warp - first < second)
    pack_word(more_lines, more_bits, g, more_words, warp - first);
  note_time(done_ns);
}

template <class T>
struct FillWith
{
  T* to;
  T value;
  __device__ void operator()(int i) const { to[i] = value; }
};

/** Copies a frame from host memory: the context, and the points where they are not copied
 * otherwise. */
struct FetchFrame
{
  const std::uint32_t* staged_context;
  const float4* staged_points;
  std::uint32_t* context;
  float4* points;
  int context_words, point_quads;
  __device__ void operator()(int i) const
  {
    if (i < context_words) context[i] = staged_context[i];
    if (i < point_quads) points[i] = staged_points[i];
  }
};

}  // namespace talus::loops
