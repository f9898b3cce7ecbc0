#pragma once
#include "kernels/1_accept.h"
#include "kernels/3_update.h"
#include "kernels/4_classify.h"
#include "kernels/map.h"

namespace talus::kernels
{
// Labels of points, by the cells after the last frame and stage 4. They decide nothing in the map.

/** The values of talus::PointLabel. */
enum Label : std::uint32_t
{
  kLabelNotTaken = 0,
  kLabelGround,
  kLabelStands,
  kLabelHangs,
  kLabelMovedAway,
  kLabelBelowGround,
  kLabelOutside
};

/** A point above the cell that it lies in, and what is known of both. */
struct PointInCell
{
  float height_m;  //!< above the datum
  std::int32_t from_below;  //!< higher than its sensor, and not on an object that moved away
  std::int32_t on_object;  //!< the lowest surface is an object, and no ground is known below it
};

/** Whether what is higher than the clearance above a cell on which nothing stands hangs there: rays
 * or the robot passed below it, or it was hit from below, see UpdateCell::put(). */
TALUS_HD bool hangs_over(const Cell& c, const PointInCell& p)
{
  const bool passed = c.is(kPassedBelow) | c.is(kRobotWasThere);
  const bool free = (c.state == kMeasured) | c.is(kPassedLow);
  return passed | (free & (p.from_below != 0) & !object_left(c.recent_hits));
}

/** Whether something stands on the ground of a cell. */
TALUS_HD bool has_object(float ground_m, float elevation_m, const Config& k)
{
  return elevation_m > bare_up_to_m(ground_m, k);  // false if not measured
}

/** Of a point above the datum; kNoSurface also without ground. `on_object`: see PointInCell. */
TALUS_HD std::int32_t surface_at(const Cell& c, bool on_object, float height_m, const Config& k)
{
  if (height_m <= bare_up_to_m(c.ground_m, k) || is_driven_through(c, height_m))
  {
    if (on_object) return kOfObject;
    return height_m < c.ground_m - kBuried_m ? kNoSurface : kOfGround;
  }
  const bool stands = has_object(c.ground_m, c.elevation_m, k);
  return stands && height_m <= c.elevation_m + k.step_threshold_m ? kOfObject : kNoSurface;
}

TALUS_HD Label label_in_cell(const Cell& c, const PointInCell& p, const Config& k)
{
  if (c.state == kUnknown) return kLabelOutside;
  const std::int32_t surface = surface_at(c, p.on_object != 0, p.height_m, k);
  if (surface != kNoSurface) return surface == kOfGround ? kLabelGround : kLabelStands;
  if (p.height_m < c.ground_m - kBuried_m) return kLabelBelowGround;
  const bool stands = has_object(c.ground_m, c.elevation_m, k);
  const float top_m = select(stands, c.elevation_m, c.ground_m);
  const bool has_room_below = p.height_m - top_m > k.clearance_m;
  return has_room_below && (stands || hangs_over(c, p)) ? kLabelHangs : kLabelMovedAway;
}

/** Gives a point of any frame its label. */
struct LabelPoint
{
  const Map& m;

  /** Finds its cell, too; -1: it has none. */
  TALUS_HD Label label(int point_i, int& storage_i) const
  {
    storage_i = -1;
    const Point sensed = m.in.at(point_i);
    const WindowPose pose = pose_of_point(*m.frame, m.in.time_s, point_i);
    const Verdict verdict = accept(sensed, rise_above_sensor(pose, sensed), m.k);
    if (verdict.code != kAccepted || is_body(sensed, *m.frame, *m.body)) return kLabelNotTaken;
    const Point p = transform(pose, sensed);
    const float n = static_cast<float>(m.k.cells);
    const float cx = p.x_m * m.k.inverse_resolution, cy = p.y_m * m.k.inverse_resolution;
    if (!((cx >= 0.0f) & (cx < n) & (cy >= 0.0f) & (cy < n))) return kLabelOutside;
    const int ix = floor_to_int(cx), iy = floor_to_int(cy);
    storage_i = m.at(ix, iy);
    const bool from_below =
        p.z_m > m.frame->sensor_z_map_m && !(m.moved && m.moved[storage_i] != 0);
    const PointInCell point{p.z_m - m.datum->offset_m, from_below, is_object(ix, iy, storage_i)};
    return label_in_cell(m.cell.load(storage_i), point, m.k);
  }

 private:
  TALUS_HD bool is_object(int ix, int iy, int storage_i) const
  {
    return ClassifyCell{m}.class_of(ix, iy, storage_i) == kObject;
  }
};

/** Notes where a point's object moved away: hits above it, higher than the sensor, went with it. */
template <class Atomics>
struct NoteMoved
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    int storage_i;
    if (LabelPoint{m}.label(point_i, storage_i) == kLabelMovedAway)
      Atomics::max(m.notes_moved + storage_i, 1);
  }
};

}  // namespace talus::kernels
