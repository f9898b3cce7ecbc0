#pragma once
#include "kernels/cell.h"
#include "kernels/coarse_grid.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/group.h"
#include "kernels/math.h"
#include "kernels/rule_constants.h"
#include "kernels/rule_switches.h"

namespace talus::kernels
{

/** Sets the class of a cell from its state alone, which is right for most cells. */
struct ClassifyByState
{
  CellStore store;
  std::uint8_t* surface_class;  //!< by storage index

  TALUS_HD void operator()(int, int, int storage_i) const
  {
    const int state = store.state[storage_i];
    const bool keep = (state == kMeasured) | (state == kPresumed);
    surface_class[storage_i] = static_cast<std::uint8_t>(select(keep, kKeep, kInfer));
  }
};

/** Decides for the cells that need more than their state. */
struct ClassifyCell
{
  const Config* config;
  const FrameContext* frame;
  CellStore store;
  CoarseGrid grid;
  const float* top_hit_m;  //!< highest hits of this frame, by storage index
  std::uint8_t* surface_class;  //!< by storage index

  TALUS_HD bool applies(int x, int y, int storage_i) const
  {
    const float ground = store.ground_m[storage_i];
    const bool measured = store.state[storage_i] == kMeasured;
    const bool stays = may_be_ground(
        grid.at(grid.place_of(x, frame->odd_x), grid.place_of(y, frame->odd_y)), ground);
    return select(measured, !stays, may_join(storage_i, ground)) | may_be_top(storage_i, ground);
  }
  TALUS_HD void operator()(int x, int y, int storage_i) const
  {
    decide(x, y, storage_i);
    if (needs_inspection(x, y, storage_i)) inspect(x, y, storage_i, SerialGroup{});
  }

  TALUS_HD void decide(int x, int y, int storage_i) const
  {
    const int px = grid.place_of(x, frame->odd_x), py = grid.place_of(y, frame->odd_y);
    if (store.state[storage_i] == kMeasured)
      surface_class[storage_i] = class_of_measured(px, py, store.ground_m[storage_i]);
    else
      join_column(storage_i);
  }

  /** Whether inspect() has to follow: the hit may be the top of an object with an overhang. */
  TALUS_HD bool needs_inspection(int x, int y, int storage_i) const
  {
    return may_be_top(storage_i, store.ground_m[storage_i]) &&
           is_before(x, y, top_hit_m[storage_i]);
  }

  /** A hit too high to stand on the ground may belong to an object whose face overhangs on the side
   * of the sensor. Seen from above it is the top of that object, such as a trailer or a car: the
   * robot fits neither below the face nor below the middle. It gets the stay and the depth of an
   * overhang. */
  template <class Group>
  TALUS_HD void inspect(int x, int y, int storage_i, const Group& group) const
  {
    const float depth_m = depth_before(x, y, top_hit_m[storage_i], group);
    if (group.rank() == 0 && is_known(depth_m)) put_overhang(storage_i, depth_m);
  }

 private:
  TALUS_HD bool may_be_ground(int coarse_i, float ground_m) const
  {
    return (ground_m <= grid.limit_m[coarse_i]) | !on(kNarrowAndSteep, *config);
  }
  TALUS_HD bool hit_above(int storage_i, float ground_m) const
  {
    return top_hit_m[storage_i] > ground_m + config->clearance_m;
  }
  /** A hit below the sensor cannot be the underside of a roof. */
  TALUS_HD bool seen_from_above(int storage_i) const
  {
    return top_hit_m[storage_i] <= frame->sensor_z_m;
  }
  TALUS_HD bool may_join(int storage_i, float ground_m) const
  {
    return !is_known(store.elevation_m[storage_i]) & hit_above(storage_i, ground_m);
  }
  TALUS_HD bool may_be_top(int storage_i, float ground_m) const
  {
    const bool stands =
        store.elevation_m[storage_i] > ground_m + kStandsAlready_clearances * config->clearance_m;
    const bool guess = store.state[storage_i] == kFilledOneSided;  // for join_column()
    return on(kTopBehindFace, *config) & hit_above(storage_i, ground_m) &
           seen_from_above(storage_i) & !stands & !guess;
  }
  TALUS_HD void put_overhang(int storage_i, float depth_m) const
  {
    put_top(storage_i);
    store.stay_frames[storage_i] = kOverhangStay;
    store.passed_frames[storage_i] = 0;
    store.overhang_below[storage_i] = static_cast<std::uint8_t>(overhang_units(depth_m));
    store.overhang_above[storage_i] = 0;
    store.flags[storage_i] &= static_cast<std::uint8_t>(~kOpen);
  }
  /** A high hit over a guess hangs. If it is seen from above, it stands until a ray passes low over
   * the guess. */
  TALUS_HD void join_column(int storage_i) const
  {
    if (!on(kRoofStands, *config) || !may_join(storage_i, store.ground_m[storage_i])) return;
    if (store.is(kPassedLow, storage_i) || !seen_from_above(storage_i)) return;
    store.flags[storage_i] |= kHitHighUp;
    put_top(storage_i);
  }
  TALUS_HD void put_top(int storage_i) const
  {
    store.elevation_m[storage_i] = top_hit_m[storage_i];
    store.elevation_var_m2[storage_i] = config->min_variance_m2;
  }

  TALUS_HD SurfaceClass class_of_measured(int px, int py, float ground_m) const
  {
    if (may_be_ground(grid.at(px, py), ground_m) || continues_wide_ground(px, py, ground_m))
      return kKeep;
    const float column_m = column_beside(px, py);
    if (column_m + config->clearance_m < ground_m) return kObject;
    const bool past = column_m > ground_m + kPastObject_steps * config->step_threshold_m;
    return past && on(kHangsBeside, *config) ? kObjectBesideColumn : kObjectOnColumn;
  }

  /** Whether level, bare ground leads from here to wide ground. A bridge, a dam or a jetty is
   * narrow and steep, but no object. */
  TALUS_HD bool continues_wide_ground(int px, int py, float ground_m) const
  {
    if (!on(kBridges, *config)) return false;
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++)
        if ((dx != 0 || dy != 0) && reaches_wide_ground(px, py, dx, dy, ground_m)) return true;
    return false;
  }
  TALUS_HD bool reaches_wide_ground(int px, int py, int dx, int dy, float ground_m) const
  {
    const float tolerance_m = kAboveCone_steps * config->step_threshold_m;
    for (int r = 1; r <= widest_thing(*config); r++)
    {
      const int qx = px + r * dx, qy = py + r * dy;
      if (qx < 0 || qy < 0 || qx >= grid.side || qy >= grid.side) return false;
      const int coarse_i = grid.at(qx, qy);
      const float lowest_m = grid.lowest_m[coarse_i], eroded_m = grid.eroded_m[coarse_i];
      const bool level = abs_of(lowest_m - ground_m) <= tolerance_m;  // false if unknown
      if (!level || grid.column_m[coarse_i] > -kInfinity) return false;
      if (eroded_m >= lowest_m - tolerance_m && eroded_m < kInfinity) return true;
    }
    return false;
  }

  /** Corridors from a cell to the sensor, each a pair of cells wide. */
  struct Corridors
  {
    int px, py;
    float x, y;  //!< unit vector to the sensor
  };
  TALUS_HD Corridors corridors_from(int x, int y) const
  {
    const auto dx = static_cast<float>(frame->sensor_cell_x - x);
    const auto dy = static_cast<float>(frame->sensor_cell_y - y);
    const float length = max_of(sqrtf(dx * dx + dy * dy), 1.0f);
    return {
        grid.place_of(x, frame->odd_x), grid.place_of(y, frame->odd_y), dx / length, dy / length};
  }
  /** The nearest coarse cell of a corridor with a face of that height, or -1. Objects are narrower
   * than ground, which bounds the search. */
  TALUS_HD int face_in_corridor(const Corridors& corridors, int corridor, float of_top_m) const
  {
    const auto beside = static_cast<float>(corridor - kFaceCorridors / 2);
    const float tolerance_m = kSameThing_steps * config->step_threshold_m;
    const float lowest_m = of_top_m - tolerance_m, highest_m = of_top_m + tolerance_m;
    const int here = grid.at(corridors.px, corridors.py);  // stands for "no face"
    int nearest = -1;
    for (int r = widest_thing(*config); r >= 1; r--)  // no early exit, so that a device reads ahead
    {
      const float ahead = static_cast<float>(r);
      const int qx = corridors.px + floor_to_int(ahead * corridors.x - beside * corridors.y + 0.5f);
      const int qy = corridors.py + floor_to_int(ahead * corridors.y + beside * corridors.x + 0.5f);
      const bool inside = (qx >= 0) & (qy >= 0) & (qx < grid.side) & (qy < grid.side);
      const int coarse_i = select(inside, grid.at(qx, qy), here);
      const float top_m = grid.overhang_m[coarse_i];
      const bool is_face = (coarse_i != here) & (top_m >= lowest_m) & (top_m <= highest_m);
      nearest = select(is_face, coarse_i, nearest);
    }
    return nearest;
  }
  /** Whether one of the two middle corridors has a face, as depth_before() needs. */
  TALUS_HD bool is_before(int x, int y, float of_top_m) const
  {
    const Corridors corridors = corridors_from(x, y);
    const int middle = kFaceCorridors / 2;
    return face_in_corridor(corridors, middle, of_top_m) >= 0 ||
           face_in_corridor(corridors, middle + 1, of_top_m) >= 0;
  }
  /** How far the overhang between a cell and the sensor reaches down. All corridors but one must
   * have a face, so that it is wider than the leg of a table; else NaN. */
  template <class Group>
  TALUS_HD float depth_before(int x, int y, float of_top_m, const Group& group) const
  {
    const Corridors corridors = corridors_from(x, y);
    int missing = 0;
    float depth_m = 0;
    for (int corridor = group.rank(); corridor < kFaceCorridors; corridor += group.size())
    {
      const int coarse_i = face_in_corridor(corridors, corridor, of_top_m);
      if (coarse_i < 0)
        missing++;
      else
        depth_m = max_of(depth_m, grid.overhang_depth_m[coarse_i]);
    }
    depth_m = group.max(depth_m);
    return group.sum(missing) <= kMissingCorridors ? depth_m : kNan;
  }

  /** Highest upright top in the coarse cell or next to it. It must stand: an object that hangs
   * cannot join itself to the ground. */
  TALUS_HD float column_beside(int px, int py) const
  {
    float column = -kInfinity;
    for (int y = py - 1; y <= py + 1; y++)
      for (int x = px - 1; x <= px + 1; x++)
      {
        const int coarse_i = grid.at(x, y);
        const bool stands = !on(kOnlyStandingJoins, *config) ||
                            grid.lowest_m[coarse_i] <= grid.cone_m[coarse_i] + config->clearance_m;
        column = max_of(column, select(stands, grid.column_m[coarse_i], -kInfinity));
      }
    return column;
  }
};

}  // namespace talus::kernels
