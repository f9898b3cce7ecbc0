#pragma once
#include "kernels/3_roll.h"
#include "kernels/rays.h"

namespace talus::kernels
{
// Mirrors and wet cars send points back from below the ground. Such a ray would have passed under
// ground that the same scan sees in the same direction, nearer, where the map has ground too. It
// saw that ground from above: what a rising ray meets may be the underside of something. (So below
// ground that is higher than the sensor reflections stay.)

/** A hit is on known ground if it is this near to it; a ray is buried if it passes this far below.
 */
constexpr float kOnGround_m = 0.1f, kBuried_m = 0.2f;

/** For a hit in one place of the table: the slope that a ray must keep to pass over known ground
 * that was hit there; -infinity where none was. */
struct FindGroundHits
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;

  /** Where the cell of a place of the table is stored, or -1: the map has no ground there. */
  TALUS_HD int cell_at(const BinDirection& d, int ring) const
  {
    const int n = config->cells;
    const float scale = config->inverse_resolution, chebyshev_m = distance_m(ring);
    const int ix = floor_to_int((frame->sensor_x_m + d.x * chebyshev_m) * scale);
    const int iy = floor_to_int((frame->sensor_y_m + d.y * chebyshev_m) * scale);
    const bool inside =
        (ring > 0) & (ring < ring_count(*config) - 1) & (ix >= 0) & (iy >= 0) & (ix < n) & (iy < n);
    const bool known = inside & !entered_window(*frame, n, ix, iy);
    return select(known, storage_index(*frame, n, ix, iy), -1);
  }
  /** The limit from what that cell holds. */
  TALUS_HD float limit(int ring, std::int32_t hit, int state, float ground_m) const
  {
    const float slope = float_from_ordered(hit);
    const float height = frame->sensor_z_m + slope * distance_m(ring);
    const bool on_ground =
        (state == kMeasured) & (abs_of(height - ground_m) < kOnGround_m) & (slope < 0.0f);
    return select(on_ground, slope - margin(ring), -kInfinity);
  }
  /** How much lower than a hit the limit is that it may set. */
  TALUS_HD float margin(int ring) const { return kBuried_m / distance_m(ring); }

 private:
  TALUS_HD float distance_m(int ring) const
  {
    return (static_cast<float>(ring) + 0.5f) * config->resolution_m;
  }
};

/** What a direction has seen so far, from the sensor outwards. It follows the second highest limit,
 * so that one wrong cell does not blind it. */
struct BuriedBelow
{
  float highest = -kInfinity, second = -kInfinity;

  /** Takes the next hit and the limit that it sets; true if the hit is buried itself. */
  TALUS_HD bool meet(std::int32_t hit, float limit)
  {
    if (float_from_ordered(hit) < second) return true;
    add(limit);
    return false;
  }
  /** The limit of a buried hit is below the second highest: it need not be left out. */
  TALUS_HD void add(float limit)
  {
    second = max_of(second, min_of(highest, limit));
    highest = max_of(highest, limit);
  }
  /** What another stretch of the direction has seen. */
  TALUS_HD void add(const BuriedBelow& other)
  {
    second = max_of(max_of(second, other.second), min_of(highest, other.highest));
    highest = max_of(highest, other.highest);
  }
};

/** The lowest hit of a stretch of a direction. */
struct LowestHit
{
  std::int32_t slope = kNoRay;

  TALUS_HD void add(std::int32_t hit) { slope = min_of(slope, hit); }
  TALUS_HD void add(const LowestHit& other) { add(other.slope); }
};

/** The rays of one direction, for executors that cut it into stretches: removes the buried ones,
 * then replaces each ring's lowest hit by the lowest ray that went at least that far. Each step
 * takes a stretch and what the stretches before it, or behind it, have seen. */
struct SettleRays
{
  using Before = BuriedBelow;
  using Behind = LowestHit;
  FindGroundHits ground;
  std::int32_t* rays;
  float* lowest_slope;  //!< of a ray that is not buried, where there is a hit; same layout as rays

  /** First step: of the rings [begin, end), outwards. */
  TALUS_HD void look(int bin, int begin, int end, BuriedBelow& seen) const
  {
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

/** The same of some directions ring by ring, for executors that have few threads. No limits are
 * looked for in directions in which no ray could be buried, wherever known ground is. */
struct SweepRays
{
  FindGroundHits ground;
  std::int32_t* rays;
  float* lowest_slope;  //!< as SettleRays leaves it; -infinity in directions without doubt
  std::uint8_t* doubted;  //!< by direction; the last frame's before

  void operator()(int first_bin, int last_bin) const
  {
    // Copies that nothing else can write to, so that loops need not read them again.
    const Config config = *ground.config;
    const FrameContext frame = *ground.frame;
    SweepRays here = *this;
    here.ground.config = &config, here.ground.frame = &frame;
    for (int bin = first_bin; bin < last_bin; bin += kBlock)
      here.sweep(bin, min_of(kBlock, last_bin - bin));
  }

 private:
  static constexpr int kBlock = 256, kGroup = 32;

  /** Directions on the way outwards. */
  struct Directions
  {
    BuriedBelow seen[kBlock];
    float x[kBlock], y[kBlock];
  };

  int rings() const { return ring_count(*ground.config); }
  int place(int ring, int bin) const { return ring * bin_count(*ground.config) + bin; }

  void sweep(int first_bin, int bins) const
  {
    forget(first_bin, bins);
    if (find_doubted(first_bin, bins)) bury(first_bin, bins);
    for (int ring = rings() - 2; ring >= 0; ring--)
    {
      std::int32_t* const row = rays + place(ring, first_bin);
      const std::int32_t* const next = rays + place(ring + 1, first_bin);
      for (int b = 0; b < bins; b++) row[b] = min_of(row[b], next[b]);
    }
  }
  void bury(int first_bin, int bins) const
  {
    Directions d;
    for (int b = 0; b < bins; b++)
    {
      const BinDirection vector = direction_of_bin(first_bin + b, bins_per_side(*ground.config));
      d.seen[b] = {}, d.x[b] = vector.x, d.y[b] = vector.y;
    }
    for (int ring = 0; ring < rings(); ring++)
    {
      const int first = place(ring, first_bin);
      bury_ring(d, ring, rays + first, lowest_slope + first, doubted + first_bin, bins);
    }
  }
  /** What the last frame left. */
  void forget(int first_bin, int bins) const
  {
    for (int bin = first_bin; bin < first_bin + bins; bin++)
      for (int ring = 0; doubted[bin] && ring < rings(); ring++)
        lowest_slope[place(ring, bin)] = -kInfinity;
  }
  /** Finds the directions in which a ray would be buried if all hits were on known ground. */
  int find_doubted(int first_bin, int bins) const
  {
    float highest[kBlock], second[kBlock];
    std::int32_t doubt[kBlock];
    for (int b = 0; b < bins; b++) highest[b] = second[b] = -kInfinity, doubt[b] = 0;
    for (int ring = 0; ring < rings(); ring++)
    {
      const std::int32_t* const row = rays + place(ring, first_bin);
      const float margin = ground.margin(ring);
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
    for (int b = 0; b < bins; b++) doubted[first_bin + b] = static_cast<std::uint8_t>(doubt[b]);
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
  /** Lists the hits in doubted directions, since whether a place holds one cannot be guessed; the
   * last group of the list is filled up with any bin. */
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
  /** In loops that become vector code, but for the loads of the states, which are bytes. */
  void find_limits(
      const Directions& d, const std::int32_t* row, int ring, const int* bin, int hits,
      float* limit) const
  {
    int cell[kBlock], state[kBlock];
    for (int h = 0; h < hits; h++) cell[h] = ground.cell_at({d.x[bin[h]], d.y[bin[h]]}, ring);
    for (int h = 0; h < hits; h++)
    {
      const int i = max_of(cell[h], 0);
      state[h] = select(cell[h] < 0, kUnknown, ground.store.state[i]);
      limit[h] = ground.store.ground_m[i];
    }
    for (int h = 0; h < hits; h++) limit[h] = ground.limit(ring, row[bin[h]], state[h], limit[h]);
  }
};

}  // namespace talus::kernels
