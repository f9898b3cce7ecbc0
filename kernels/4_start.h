#pragma once
#include "kernels/4_underfoot.h"
#include "kernels/map.h"

namespace talus::kernels
{
/** In the first frame passable cells on the base's plane are reached: hits on the robot may lie
 * between. */
struct StartReach
{
  const Map& m;

  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    const Offset at = offset_from_base(m.k, *m.frame, ix, iy);
    const float plane_m = plane_of_base_m(*m.frame, at);
    const float radius_m = kStartReach * (m.frame->sensor_z_m - plane_m);
    const bool level =
        abs_of(m.cell.ground_m[i] - plane_m) <= kStartReach_steps * m.k.step_threshold_m;
    const int flags = m.cell.flags[i];
    const bool starts = (m.frame->has_base != 0) & level & at.is_within(radius_m) &
                        ((flags & kWasPassable) == kWasPassable);
    m.cell.flags[i] = static_cast<std::uint8_t>(flags | select(starts, kWasReached, 0));
  }
};

/** In its first frame a scanner looks over the ground on which the robot stands. Unmeasured cells
 * get the plane of the base, until they are measured or rays pass below it (stage 6). */
struct PresumeStart
{
  const Map& m;

  TALUS_HD bool leaves_out(int) const
  {
    return !((m.frame->starts_map != 0) & (m.frame->has_base != 0) & on(kPresumedStart, m.k));
  }
  TALUS_HD bool applies(int ix, int iy, int i) const
  {
    const bool near = offset_from_base(m.k, *m.frame, ix, iy).is_within(m.k.start_radius_m);
    const int state = m.cell.state[i];
    return near & (state != kMeasured) & (state != kPresumed) & !leaves_out(iy);
  }
  TALUS_HD void operator()(int ix, int iy, int i) const
  {
    const float plane_m = plane_at(ix, iy);
    if (plane_m > m.free_above_m[m.lines.at(ix, iy)] + m.k.cleanup_margin_m) return;
    // Near its start the robot has room to move off.
    const bool beside = offset_from_base(m.k, *m.frame, ix, iy).is_within(kStartsOn_m);
    if (m.k.start_automatic != 0 && !beside && !is_blind(ix, iy)) return;
    Cell c = m.cell.load(i);
    presume_ground(c, plane_m);
    m.cell.store(i, c);
  }

 private:
  TALUS_HD float plane_at(int ix, int iy) const
  {
    return plane_of_base_m(*m.frame, offset_from_base(m.k, *m.frame, ix, iy));
  }
  TALUS_HD Offset from_sensor(int ix, int iy) const
  {
    return offset_of(m.k, ix, iy, m.frame->sensor_x_m, m.frame->sensor_y_m);
  }
  TALUS_HD int cell_at(float at_m) const { return floor_to_int(at_m * m.k.inverse_resolution); }

  /** What the lowest rays over a cell show of its ground. */
  enum Ground
  {
    kNothing,  //!< they ended there, or they meet no ground within the radius
    kLevel,
    kDrop  //!< they went on to below the ground
  };

  /** Whether the scanner looks over the cell to ground that goes on. Its lowest rays there must end
   * behind it and not below the ground. Nor may those a little to its sides, since a drop is wider
   * than what is seen of it. */
  TALUS_HD bool is_blind(int ix, int iy) const
  {
    const auto [x_m, y_m] = from_sensor(ix, iy);
    const float aside_x_m = kDropBeside * y_m, aside_y_m = kDropBeside * x_m;
    return ground_of(x_m, y_m) == kLevel && ground_of(x_m - aside_x_m, y_m + aside_y_m) != kDrop &&
           ground_of(x_m + aside_x_m, y_m - aside_y_m) != kDrop;
  }
  /** Asks a nearer cell, since a cell has rays only if they ended some rings behind it. */
  TALUS_HD Ground ground_of(float x_m, float y_m) const
  {
    const float away_m = chebyshev(x_m, y_m);
    const float nearer_m = away_m - static_cast<float>(kBehindCell_rings) * m.k.resolution_m;
    if (nearer_m < (kUnderSensor_rings + 1.0f) * m.k.resolution_m) return kLevel;
    const float share = nearer_m / away_m;
    return ground_at(
        cell_at(m.frame->sensor_x_m + share * x_m), cell_at(m.frame->sensor_y_m + share * y_m));
  }
  /** How much the plane of the scanner rises up to a position. Behind a scanner that is tilted
   * forward its rays look up, but the robot turns before it drives there. */
  TALUS_HD float untilted_m(float x_m, float y_m) const
  {
    const float* const p = m.frame->poses[0].m;
    const bool upright = p[10] > kUprightScanner;
    return select(upright, -(p[2] * x_m + p[6] * y_m) / select(upright, p[10], 1.0f), -kInfinity);
  }
  TALUS_HD Ground ground_at(int ix, int iy) const
  {
    if (!m.has(ix, iy)) return kLevel;  // the sensor is outside
    const int at = m.lines.at(ix, iy);
    if (m.unobstructed[at] == 0) return kNothing;
    const auto [x_m, y_m] = from_sensor(ix, iy);
    // Heights count per Chebyshev distance, as in FindPassingRays.
    const float away_m = chebyshev(x_m, y_m);
    const float rises_m = m.frame->base_slope_x * x_m + m.frame->base_slope_y * y_m;
    const float above_m = m.frame->sensor_z_m - plane_at(ix, iy) + rises_m;
    const float slope =
        (m.lowest_ray_m[at] - m.frame->sensor_z_m) / (away_m - 0.5f * m.k.resolution_m);
    const float below_m = kStartUndercut_steps * m.k.step_threshold_m;
    const float falls = rises_m / away_m - slope;
    const float radius_m = m.k.start_radius_m * away_m / sqrtf(x_m * x_m + y_m * y_m);
    if (!(max_of(falls, untilted_m(x_m, y_m) / away_m - slope) * radius_m > above_m))
      return kNothing;
    if (!(falls * static_cast<float>(m.k.cells) * m.k.resolution_m > above_m + below_m))
      return kLevel;
    const float share = (above_m + below_m) / (falls * away_m);
    const int x = cell_at(m.frame->sensor_x_m + share * x_m);
    const int y = cell_at(m.frame->sensor_y_m + share * y_m);
    if (!m.has(x, y)) return kLevel;
    const bool deep = m.lowest_ray_m[m.lines.at(x, y)] < plane_at(x, y) - kStartDropSeen * below_m;
    return deep ? kDrop : kLevel;
  }
};

}  // namespace talus::kernels
