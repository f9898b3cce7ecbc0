#pragma once
#include "kernels/map.h"

namespace talus::kernels
{
// Mirrors and wet cars reflect rays, so that points appear below the ground. Such a ray would have
// passed under mapped ground that the same scan hits nearer in the same direction. Only ground
// below the sensor counts: a rising ray may hit an underside.

/** The slope that keeps a ray above known ground that was hit, by ray; -infinity without such. */
struct FindGroundHits
{
  const Map& m;

  /** Storage index of the cell at an index of the table, or -1 where the map has no ground. */
  TALUS_HD int cell_at(const BinDirection& d, int ring) const
  {
    const float scale = m.k.inverse_resolution, chebyshev_m = distance_m(ring);
    const int ix = floor_to_int((m.frame->sensor_x_m + d.x * chebyshev_m) * scale);
    const int iy = floor_to_int((m.frame->sensor_y_m + d.y * chebyshev_m) * scale);
    const bool inside = (ring > 0) & (ring < m.frame->rings - 1) & m.has(ix, iy);
    const bool known = inside & !entered_window(*m.frame, m.k.cells, ix, iy);
    return select(known, m.at(ix, iy), -1);
  }
  TALUS_HD float limit(int ring, std::int32_t hit, int state, float ground_m) const
  {
    const float slope = float_from_ordered(hit);
    const bool on_ground = on(kBuriedRays, m.k) & (state == kMeasured) & (slope < 0.0f) &
                           (abs_of(height_m(ring, hit) - ground_m) < kOnGround_m);
    return select(on_ground, slope - margin(ring), -kInfinity);
  }
  /** Height of a hit above the datum of the last frame. */
  TALUS_HD float height_m(int ring, std::int32_t hit) const
  {
    return m.frame->sensor_z_map_m - m.datum_before->offset_m +
           float_from_ordered(hit) * distance_m(ring);
  }
  /** How far the limit of a hit lies below that hit, as a slope. */
  TALUS_HD float margin(int ring) const { return kBuried_m / distance_m(ring); }

 private:
  TALUS_HD float distance_m(int ring) const
  {
    return (static_cast<float>(ring) + 0.5f) * m.k.resolution_m;
  }
};

/** The limits along a direction, outwards; the second highest counts against one wrong cell. */
struct BuriedBelow
{
  float highest = -kInfinity, second = -kInfinity;

  /** Adds the next hit and its limit; true if the hit itself is buried. */
  TALUS_HD bool meet(std::int32_t hit, float limit)
  {
    if (float_from_ordered(hit) < second) return true;
    add(limit);
    return false;
  }
  /** The limit of a buried hit is below the second highest, so it may be added like any other. */
  TALUS_HD void add(float limit)
  {
    second = max_of(second, min_of(highest, limit));
    highest = max_of(highest, limit);
  }
  TALUS_HD void add(const BuriedBelow& other)
  {
    second = max_of(max_of(second, other.second), min_of(highest, other.highest));
    highest = max_of(highest, other.highest);
  }
};

/** Whether the ray of a point is buried, once the slopes of its direction are known. */
TALUS_HD bool is_buried(const Map& m, int point_i)
{
  const int ray = m.point_ray[point_i];
  return ray >= 0 && m.point_slope[point_i] < m.lowest_slope[ray];
}

/** The lowest hit in a range of rings of one direction. */
struct LowestHit
{
  std::int32_t slope = kNoRay;

  TALUS_HD void add(std::int32_t hit) { slope = min_of(slope, hit); }
  TALUS_HD void add(const LowestHit& other) { add(other.slope); }
};

}  // namespace talus::kernels
