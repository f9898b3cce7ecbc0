#pragma once
#include "kernels/1_buried_rays.h"

namespace talus::kernels
{
/** Removes the buried rays of some directions ring by ring, and replaces each lowest hit by the
 * lowest ray that went at least that far, as SettleRays does on a device. It computes no limits in
 * directions where no ray could be buried, wherever there is known ground. */
struct SweepRays
{
  const Map& m;

  void operator()(int first_bin, int last_bin) const
  {
    // Copies that nothing else can write to, so that loops need not read them again.
    Map mine = m;
    FrameContext frame = *m.frame;
    Datum datum = *m.datum_before;
    mine.frame = &frame, mine.datum_before = &datum;
    for (int bin = first_bin; bin < last_bin; bin += kBlock)
      SweepRays{mine}.sweep(bin, min_of(kBlock, last_bin - bin));
  }

 private:
  static constexpr int kBlock = 256, kGroup = 32;

  /** Sums of some directions outwards. */
  struct Directions
  {
    BuriedBelow seen[kBlock];
    float x[kBlock], y[kBlock];
  };

  int rings() const { return m.frame->rings; }
  FindGroundHits ground() const { return {m}; }
  int ray_at(int ring, int bin) const { return ring * bin_count(m.k) + bin; }

  void sweep(int first_bin, int bins) const
  {
    forget(first_bin, bins);
    if (find_doubted(first_bin, bins)) bury(first_bin, bins);
    for (int ring = rings() - 2; ring >= 0; ring--)
    {
      std::int32_t* const row = m.rays + ray_at(ring, first_bin);
      const std::int32_t* const next = m.rays + ray_at(ring + 1, first_bin);
      for (int b = 0; b < bins; b++) row[b] = min_of(row[b], next[b]);
    }
  }
  void bury(int first_bin, int bins) const
  {
    Directions d;
    for (int b = 0; b < bins; b++)
    {
      const BinDirection vector = direction_of_bin(first_bin + b, bins_per_side(m.k));
      d.seen[b] = {}, d.x[b] = vector.x, d.y[b] = vector.y;
    }
    for (int ring = 0; ring < rings(); ring++)
    {
      const int first = ray_at(ring, first_bin);
      bury_ring(d, ring, m.rays + first, m.lowest_slope + first, m.doubted + first_bin, bins);
    }
  }
  /** Clears the values of the last frame. */
  void forget(int first_bin, int bins) const
  {
    for (int bin = first_bin; bin < first_bin + bins; bin++)
      for (int ring = 0; m.doubted[bin] && ring < rings(); ring++)
        m.lowest_slope[ray_at(ring, bin)] = -kInfinity;
  }
  /** Finds the directions in which a ray would be buried if all hits were on known ground. */
  int find_doubted(int first_bin, int bins) const
  {
    float highest[kBlock], second[kBlock];
    std::int32_t doubt[kBlock];
    for (int b = 0; b < bins; b++) highest[b] = second[b] = -kInfinity, doubt[b] = 0;
    for (int ring = 0; ring < rings(); ring++)
    {
      const std::int32_t* const row = m.rays + ray_at(ring, first_bin);
      const float margin = ground().margin(ring);
      for (int b = 0; b < bins; b++)
      {
        const bool hit = row[b] != kNoRay;
        const float slope = select(hit, float_from_ordered(row[b]), kInfinity);
        BuriedBelow seen{highest[b], second[b]};
        doubt[b] |= select(slope < seen.second, 1, 0);
        seen.add(select(hit, slope - margin, -kInfinity));
        highest[b] = seen.highest, second[b] = seen.second;
      }
    }
    int any = 0;
    for (int b = 0; b < bins; b++) any |= doubt[b];
    for (int b = 0; b < bins; b++) m.doubted[first_bin + b] = static_cast<std::uint8_t>(doubt[b]);
    return any;
  }
  void bury_ring(
      Directions& d, int ring, std::int32_t* row, float* slope, const std::uint8_t* doubt,
      int bins) const
  {
    int bin[kBlock];
    float limit[kBlock];
    const int hits = list_hits(row, doubt, bins, bin);
    find_limits(d, row, ring, bin, (hits + kGroup - 1) / kGroup * kGroup, limit);
    for (int h = 0; h < hits; h++)
    {
      const int b = bin[h];
      slope[b] = d.seen[b].second;
      if (d.seen[b].meet(row[b], limit[h])) row[b] = kNoRay;
    }
  }
  /** Lists the hits in doubted directions, which a branch could not predict. The last group of the
   * list is filled up with any bin. */
  static int list_hits(const std::int32_t* row, const std::uint8_t* doubt, int bins, int* bin)
  {
    int hits = 0;
    for (int first = 0; first < bins; first += kGroup)
    {
      const int last = min_of(first + kGroup, bins);
      int any = 0;
      for (int b = first; b < last; b++) any |= (row[b] != kNoRay) & doubt[b];
      if (!any) continue;
      for (int b = first; b < last; b++)
      {
        bin[hits] = b;
        hits += (row[b] != kNoRay) & doubt[b];
      }
    }
    for (int h = hits; h % kGroup; h++) bin[h] = 0;
    return hits;
  }
  /** Its loops become vector code, except for the loads of the states, which are bytes. */
  void find_limits(
      const Directions& d, const std::int32_t* row, int ring, const int* bin, int hits,
      float* limit) const
  {
    int cell[kBlock], state[kBlock];
    for (int h = 0; h < hits; h++) cell[h] = ground().cell_at({d.x[bin[h]], d.y[bin[h]]}, ring);
    for (int h = 0; h < hits; h++)
    {
      const int i = max_of(cell[h], 0);
      state[h] = select(cell[h] < 0, kUnknown, m.cell.state[i]);
      limit[h] = m.cell.ground_m[i];
    }
    for (int h = 0; h < hits; h++) limit[h] = ground().limit(ring, row[bin[h]], state[h], limit[h]);
  }
};

}  // namespace talus::kernels
