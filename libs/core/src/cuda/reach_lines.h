#pragma once
#include "kernels/4_reach.h"

namespace talus::kernels
{
// The sweeps of 4_reach.h on a device: a warp for each line of pairs, beside loops that take as
// long. What is reached spreads over the 32 pairs of a word at once.

/** Pools one pair. */
struct PoolReachOfPair
{
  const Map& m;

  TALUS_HD void operator()(int i) const
  {
    const int side = m.pairs.side, py = floor_div(i, side, 1.0f / static_cast<float>(side));
    PoolReach{m}(i - py * side, py);
  }
};

/** Spreads along a row or a column, by the threads [32 line, 32 line + 32). */
template <bool kColumns>
struct SpreadAlongLine
{
  const Map& m;

  static constexpr int kThreads = 32;
  TALUS_HD void operator()(int thread) const
  {
    const int line = thread / kThreads;
#if defined(__CUDA_ARCH__)
    const PairGrid grid = m.pairs;
    const int row = grid.at(0, 1) - grid.at(0, 0);
    std::int32_t* const first = m.pair_reach + (kColumns ? grid.at(line, 0) : grid.at(0, line));
    const int step = kColumns ? row : 1, words = (grid.side + kThreads - 1) / kThreads;
    std::uint32_t carry = 0;
    for (int word = 0; word < words; word++) carry = spread<true>(first, step, word, carry);
    carry = 0;
    for (int word = words; word-- > 0;) carry = spread<false>(first, step, word, carry);
#else
    if (thread % kThreads != 0) return;
    SpreadReach<kColumns>{m}(line, line + 1);
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
    const std::int32_t before = i < m.pairs.side ? *pair : kOutsideWindow;
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

}  // namespace talus::kernels
