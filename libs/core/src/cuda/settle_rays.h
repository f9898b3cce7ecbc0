#pragma once
#include "kernels/1_buried_rays.h"

namespace talus::kernels
{
/** Settles the rays of one direction in ranges: removes the buried ones, then replaces each ring's
 * lowest hit by the lowest ray that went at least that far. Each step takes a range and the sums of
 * the ranges before it, or behind it. */
struct SettleRays
{
  using Before = BuriedBelow;
  using Behind = LowestHit;
  const Map& m;

  TALUS_HD int rings() const { return m.frame->rings; }
  /** First step, outwards over the rings [begin, end). */
  TALUS_HD void collect(int bin, int begin, int end, BuriedBelow& seen) const
  {
    for (int ring = begin; ring < end; ring += kBatch)
    {
      std::int32_t hits[kBatch];
      load(bin, ring, end, hits);
      const Cells cells = cells_at(bin, ring, hits);
      for (int b = 0; b < kBatch; b++)
      {
        const float limit =
            FindGroundHits{m}.limit(ring + b, hits[b], cells.state[b], cells.ground_m[b]);
        if (hits[b] != kNoRay) m.lowest_slope[ray_at(bin, ring + b)] = limit;
        seen.add(limit);
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
        limits[b] = hits[b] != kNoRay ? m.lowest_slope[ray_at(bin, ring + b)] : -kInfinity;
      for (int b = 0; b < kBatch; b++)
      {
        if (hits[b] == kNoRay) continue;
        const int r = ray_at(bin, ring + b);
        m.lowest_slope[r] = seen.second;
        if (seen.meet(hits[b], limits[b]))
          m.rays[r] = kNoRay;
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
        if (ring + b < end) m.rays[ray_at(bin, ring + b)] = lowest.slope;
      }
    }
  }

 private:
  static constexpr int kBatch = 8;

  // The loads come first, so that they do not wait for each other.

  /** The cells under hits; unknown without a hit or a cell. */
  struct Cells
  {
    int state[kBatch];
    float ground_m[kBatch];
  };
  TALUS_HD Cells cells_at(int bin, int ring, const std::int32_t* hits) const
  {
    const BinDirection d = direction_of_bin(bin, bins_per_side(m.k));
    Cells c;
    for (int b = 0; b < kBatch; b++)
    {
      const int i = hits[b] != kNoRay ? FindGroundHits{m}.cell_at(d, ring + b) : -1;
      c.state[b] = i >= 0 ? static_cast<int>(m.cell.state[i]) : static_cast<int>(kUnknown);
      c.ground_m[b] = i >= 0 ? m.cell.ground_m[i] : 0.0f;
    }
    return c;
  }
  TALUS_HD void load(int bin, int ring, int end, std::int32_t* hits) const
  {
    for (int b = 0; b < kBatch; b++)
      hits[b] = ring + b < end ? m.rays[ray_at(bin, ring + b)] : kNoRay;
  }
  TALUS_HD int ray_at(int bin, int ring) const { return ring * bin_count(m.k) + bin; }
};

}  // namespace talus::kernels
