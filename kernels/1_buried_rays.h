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
// Mirrors and wet cars send points back from below the ground. Such a ray would have passed under
// ground that the same scan sees in the same direction, nearer, where the map has ground too. It
// saw that ground from above: what a rising ray meets may be the underside of something. (So below
// ground that is higher than the sensor reflections stay.)

/** For a hit in one place of the table: the slope that a ray must keep to pass over known ground
 * that was hit there; -infinity where none was. */
struct FindGroundHits
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  const Datum* datum;

  /** Where the cell of a place of the table is stored, or -1: the map has no ground there. */
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
  /** The limit from what that cell holds. */
  TALUS_HD float limit(int ring, std::int32_t hit, int state, float ground_m) const
  {
    const float slope = float_from_ordered(hit);
    const bool on_ground = on(kBuriedRays, *config) & (state == kMeasured) & (slope < 0.0f) &
                           (abs_of(height_m(ring, hit) - ground_m) < kOnGround_m);
    return select(on_ground, slope - margin(ring), -kInfinity);
  }
  /** Height of a hit above the datum that the last frame left. */
  TALUS_HD float height_m(int ring, std::int32_t hit) const
  {
    return frame->sensor_z_map_m - datum->offset_m + float_from_ordered(hit) * distance_m(ring);
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

}  // namespace talus::kernels
