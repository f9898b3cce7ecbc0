#pragma once
#include "kernels/cell.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/math.h"
#include "kernels/rays.h"
#include "kernels/rule_constants.h"
#include "kernels/rule_switches.h"

namespace talus::kernels
{
// Mirrors and wet cars reflect rays, so that points appear below the ground. Such a ray would have
// passed under mapped ground that the same scan hits nearer in the same direction. Only ground
// below the sensor counts: a rising ray may hit an underside.

/** The slope that a ray must keep to pass over known ground that was hit in one place of the table
 * of rays; -infinity where no ground was hit. */
struct FindGroundHits
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const Datum* datum;

  /** Storage index of the cell at an index of the table, or -1 where the map has no ground. */
  TALUS_HD int cell_at(const BinDirection& d, int ring) const
  {
    const int n = config->cells;
    const float scale = config->inverse_resolution, chebyshev_m = distance_m(ring);
    const int ix = floor_to_int((frame->sensor_x_m + d.x * chebyshev_m) * scale);
    const int iy = floor_to_int((frame->sensor_y_m + d.y * chebyshev_m) * scale);
    const bool inside =
        (ring > 0) & (ring < frame->rings - 1) & (ix >= 0) & (iy >= 0) & (ix < n) & (iy < n);
    const bool known = inside & !entered_window(*frame, n, ix, iy);
    return select(known, storage_index(*frame, n, ix, iy), -1);
  }
  TALUS_HD float limit(int ring, std::int32_t hit, int state, float ground_m) const
  {
    const float slope = float_from_ordered(hit);
    const bool on_ground = on(kBuriedRays, *config) & (state == kMeasured) & (slope < 0.0f) &
                           (abs_of(height_m(ring, hit) - ground_m) < kOnGround_m);
    return select(on_ground, slope - margin(ring), -kInfinity);
  }
  /** Height of a hit above the datum of the last frame. */
  TALUS_HD float height_m(int ring, std::int32_t hit) const
  {
    return frame->sensor_z_map_m - datum->offset_m + float_from_ordered(hit) * distance_m(ring);
  }
  /** How far the limit of a hit lies below that hit, as a slope. */
  TALUS_HD float margin(int ring) const { return kBuried_m / distance_m(ring); }

 private:
  TALUS_HD float distance_m(int ring) const
  {
    return (static_cast<float>(ring) + 0.5f) * config->resolution_m;
  }
};

/** The limits along one direction, from the sensor outwards. The second highest limit counts, so
 * that one wrong cell buries nothing. */
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

/** The lowest hit in a range of rings of one direction. */
struct LowestHit
{
  std::int32_t slope = kNoRay;

  TALUS_HD void add(std::int32_t hit) { slope = min_of(slope, hit); }
  TALUS_HD void add(const LowestHit& other) { add(other.slope); }
};

}  // namespace talus::kernels
