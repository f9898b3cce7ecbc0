#pragma once
#include "kernels/3_follow.h"

namespace talus::kernels
{
/** The rays of one direction, for executors that cut it into stretches: removes the buried ones,
 * then replaces each ring's lowest hit by the lowest ray that went at least that far. Each step
 * takes a stretch and what the stretches before it, or behind it, have seen. */
template <class Atomics>
struct SettleRays
{
  using Before = BuriedBelow;
  using Behind = LowestHit;
  FindGroundHits ground;
  CountOffsets<Atomics> offsets;
  std::int32_t* rays;
  float* lowest_slope;  //!< of a ray that is not buried, where there is a hit; same layout as rays

  /** First step: of the rings [begin, end), outwards. */
  TALUS_HD void collect(int bin, int begin, int end, BuriedBelow& seen) const
  {
    if (offsets.counts(bin)) offsets(bin, begin, end);
    for (int ring = begin; ring < end; ring += kBatch)
    {
      std::int32_t hits[kBatch];
      load(bin, ring, end, hits);
      float limits[kBatch];
      find_limits(bin, ring, hits, limits);
      for (int b = 0; b < kBatch; b++)
      {
        if (hits[b] != kNoRay) lowest_slope[place(bin, ring + b)] = limits[b];
        seen.add(limits[b]);
      }
    }
  }
  /** Second step, outwards. */
  TALUS_HD void bury(int bin, int begin, int end, BuriedBelow& seen, LowestHit& lowest) const
  {
    for (int ring = begin; ring < end; ring += kBatch)
    {
      std::int32_t hits[kBatch];
      load(bin, ring, end, hits);
      float limits[kBatch];
      for (int b = 0; b < kBatch; b++)
        limits[b] = hits[b] != kNoRay ? lowest_slope[place(bin, ring + b)] : -kInfinity;
      for (int b = 0; b < kBatch; b++)
      {
        if (hits[b] == kNoRay) continue;
        const int r = place(bin, ring + b);
        lowest_slope[r] = seen.second;
        if (seen.meet(hits[b], limits[b]))
          rays[r] = kNoRay;
        else
          lowest.add(hits[b]);
      }
    }
  }
  /** Third step, inwards. */
  TALUS_HD void sweep(int bin, int begin, int end, LowestHit& lowest) const
  {
    for (int ring = begin + (end - begin - 1) / kBatch * kBatch; ring >= begin; ring -= kBatch)
    {
      std::int32_t hits[kBatch];
      load(bin, ring, end, hits);
      for (int b = kBatch - 1; b >= 0; b--)
      {
        lowest.add(hits[b]);
        if (ring + b < end) rays[place(bin, ring + b)] = lowest.slope;
      }
    }
  }

 private:
  static constexpr int kBatch = 8;

  // Loads first, so that they do not wait for each other.

  TALUS_HD void find_limits(int bin, int ring, const std::int32_t* hits, float* limits) const
  {
    const BinDirection d = direction_of_bin(bin, bins_per_side(*ground.config));
    float ground_m[kBatch];
    int state[kBatch];
    for (int b = 0; b < kBatch; b++)
    {
      const int i = hits[b] != kNoRay ? ground.cell_at(d, ring + b) : -1;
      state[b] = i >= 0 ? static_cast<int>(ground.store.state[i]) : static_cast<int>(kUnknown);
      ground_m[b] = i >= 0 ? ground.store.ground_m[i] : 0.0f;
    }
    for (int b = 0; b < kBatch; b++)
      limits[b] = ground.limit(ring + b, hits[b], state[b], ground_m[b]);
  }
  TALUS_HD void load(int bin, int ring, int end, std::int32_t* hits) const
  {
    for (int b = 0; b < kBatch; b++) hits[b] = ring + b < end ? rays[place(bin, ring + b)] : kNoRay;
  }
  TALUS_HD int place(int bin, int ring) const { return ring * bin_count(*ground.config) + bin; }
};

}  // namespace talus::kernels
