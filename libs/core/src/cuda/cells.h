#pragma once
#include "kernels/4_reach.h"
#include "kernels/5_cleanup.h"
#include "kernels/6_fill.h"

namespace talus::kernels
{
/** Rules on one cell, before samples are sought; of CleanUpCell, since groups inspect, in parts. */
template <class... Rules>
struct SettleCell
{
  const Map& m;

  /** First step. Returns whether inspect() must follow. */
  TALUS_HD bool begin(int ix, int iy) const
  {
    const int i = m.at(ix, iy);
    bool inspects = false;
    (begin<Rules>(ix, iy, i, inspects), ...);
    return inspects;
  }
  template <class Group>
  TALUS_HD void inspect(int ix, int iy, const Group& group) const
  {
    if constexpr (kCleansUp) CleanUpCell{m}.inspect(ix, iy, m.at(ix, iy), group);
  }
  /** Last step. True for a sample. */
  TALUS_HD bool operator()(int ix, int iy) const
  {
    const int i = m.at(ix, iy);
    if constexpr (kCleansUp)
      if (CleanUpCell{m}.applies(ix, iy, i)) CleanUpCell{m}.finish(ix, iy, i);
    return TakeSample{m}(ix, iy, i);
  }

 private:
  static constexpr bool kCleansUp = (std::is_same_v<Rules, CleanUpCell> || ...);

  template <class Rule>
  TALUS_HD void begin(int ix, int iy, int i, bool& inspects) const
  {
    if constexpr (std::is_same_v<Rule, CleanUpCell>)
      inspects = CleanUpCell{m}.needs_inspection(ix, iy, i);
    else
      apply<Rule>(m, ix, iy, i);
  }
};

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
