#pragma once
#include "kernels/1_accept.h"
#include "kernels/3_update.h"
#include "kernels/4_classify.h"
#include "kernels/cell.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"

namespace talus::kernels
{
// Labels of points, by the cells as they are after the last frame, and by what stage 4 says of them
// as they are. They read the map and decide nothing in it.

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

/** What the map says of a point in a cell, `height_m` above the datum. `object`: its lowest surface
 * is an object, and no ground is known below it. */
TALUS_HD Label label_in_cell(const Cell& c, bool object, float height_m, const Config& k)
{
  if (c.state == kUnknown) return kLabelOutside;
  if (height_m < c.ground_m - kBuried_m) return kLabelBelowGround;
  const float bare_m = bare_up_to_m(c.ground_m, k);
  const bool low = height_m <= bare_m || is_driven_through(c, height_m);
  if (low) return object ? kLabelStands : kLabelGround;
  const bool stands = c.elevation_m > bare_m;  // false if not measured
  if (stands && height_m <= c.elevation_m + k.step_threshold_m) return kLabelStands;
  const float top_m = select(stands, c.elevation_m, c.ground_m);
  if (!(height_m - top_m > k.clearance_m)) return kLabelMovedAway;
  const bool left = !stands && c.recent_hits > 0;
  const bool free_below = c.is(kPassedBelow) || c.is(kRobotWasThere);
  return left && !free_below ? kLabelMovedAway : kLabelHangs;
}

/** Gives a point of any frame its label. */
struct LabelPoint
{
  const Config* config;
  const FrameContext* frame;  //!< of the points, in the window of the map
  const Body* body;
  const Datum* datum;
  CellStore store;
  ClassifyCell classify;  //!< over a coarse grid of the map as it is
  KeepBridge bridge;
  PointsIn in;

  TALUS_HD std::uint32_t operator()(int point_i) const
  {
    const Point sensed = in.at(point_i);
    const WindowPose pose = pose_of_point(*frame, in.time_s, point_i);
    const Verdict verdict = accept(sensed, rise_above_sensor(pose, sensed), *config);
    if (verdict.code != kAccepted || is_body(sensed, *frame, *body)) return kLabelNotTaken;
    const Point p = transform(pose, sensed);
    const float n = static_cast<float>(config->cells);
    const float cx = p.x_m * config->inverse_resolution, cy = p.y_m * config->inverse_resolution;
    if (!((cx >= 0.0f) & (cx < n) & (cy >= 0.0f) & (cy < n))) return kLabelOutside;
    const int ix = floor_to_int(cx), iy = floor_to_int(cy);
    const int storage_i = storage_index(*frame, config->cells, ix, iy);
    const float height_m = p.z_m - datum->offset_m;
    return label_in_cell(store.load(storage_i), is_object(ix, iy, storage_i), height_m, *config);
  }

 private:
  TALUS_HD bool is_object(int ix, int iy, int storage_i) const
  {
    return classify.class_of(ix, iy, storage_i) == kObject &&
           !(on(kBridges, *config) && bridge.leads_on(ix, iy, storage_i));
  }
};

}  // namespace talus::kernels
