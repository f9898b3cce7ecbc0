#pragma once
#include "kernels/4_reach.h"

namespace talus::kernels
{
// The sweeps of 4_reach.h on a device: a warp for each line of pairs, beside loops that take as
// long. What is reached spreads over the 32 pairs of a word at once.

/** Pools one pair. */
struct PoolReachOfPair
{
  PoolReach pool;

  TALUS_HD void operator()(int i) const
  {
    const int side = pool.grid.side, py = floor_div(i, side, 1.0f / static_cast<float>(side));
    pool(i - py * side, py);
  }
};

/** Spreads along a row or a column, by the threads [32 line, 32 line + 32). */
struct SpreadAlongLine
{
  CoarseGrid grid;
  bool columns;

  static constexpr int kThreads = 32;
  TALUS_HD void operator()(int thread) const
  {
    const int line = thread / kThreads;
#if defined(__CUDA_ARCH__)
    const int row = grid.at(0, 1) - grid.at(0, 0);
    std::int32_t* const first = grid.reach + (columns ? grid.at(line, 0) : grid.at(0, line));
    const int step = columns ? row : 1, words = (grid.side + kThreads - 1) / kThreads;
    std::uint32_t carry = 0;
    for (int word = 0; word < words; word++) carry = spread<true>(first, step, word, carry);
    carry = 0;
    for (int word = words; word-- > 0;) carry = spread<false>(first, step, word, carry);
#else
    if (thread % kThreads != 0) return;
    SpreadReach{grid, columns}(line, line + 1);
#endif
  }

 private:
#if defined(__CUDA_ARCH__)
  /** Spreads within a word, from the word before by `carry`; returns that of the next one. */
  template <bool kUp>
  __device__ std::uint32_t spread(
      std::int32_t* first, int step, int word, std::uint32_t carry) const
  {
    const int lane = static_cast<int>(threadIdx.x) % kThreads, i = word * kThreads + lane;
    std::int32_t* const pair = first + i * step;
    const std::int32_t before = i < grid.side ? *pair : kOutsideWindow;
    std::uint32_t reached = __ballot_sync(~0u, before == kPairReached);
    std::uint32_t passable = __ballot_sync(~0u, before >= kPairPassable);
    reached |= passable & (kUp ? carry : carry << 31);
    for (int by = 1; by < kThreads; by *= 2)
    {
      reached |= passable & (kUp ? reached << by : reached >> by);
      passable &= kUp ? passable << by : passable >> by;
    }
    if (before == kPairPassable && (reached >> lane & 1u) != 0) *pair = kPairReached;
    return kUp ? reached >> 31 : reached & 1u;
  }
#endif
};

/** first(i) for the `firsts` first elements of a range, then(i) for the others. */
template <class First, class Then>
struct Before
{
  int firsts;
  First first;
  Then then;

  TALUS_HD void operator()(int i) const
  {
    if (i < firsts)
      first(i);
    else
      then(i - firsts);
  }
};

}  // namespace talus::kernels
