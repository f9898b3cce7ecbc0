#pragma once
#include "kernels/1_accept.h"
#include "kernels/atomics.h"
#include "kernels/cell.h"
#include "kernels/config.h"
#include "kernels/frame.h"
#include "kernels/math.h"
#include "kernels/rays.h"

namespace talus::kernels
{

/** The range of indices of one thread. */
struct Part
{
  int begin, end;
};

/** The rank of a point that lies in a cell but does not count. */
constexpr std::uint32_t kNoRank = ~0u;

/** The results of stage 1 for each point. */
struct PointsOut
{
  std::int32_t* cell;  //!< storage index, or -1: not in the map
  std::int32_t* ray;  //!< index in the table of rays, or -1: no direction
  float* slope;  //!< slope of that ray
  std::int32_t* reach;  //!< index in the table of NoteReach, or -1
  std::uint32_t* reject;  //!< a RejectCode
  std::uint32_t* rank;  //!< index among the points of its cell, in any order; or kNoRank
  float* height_m;  //!< map frame
  float* variance_m2;
};

/** Enters the ray of a point into the table of rays. */
template <class Atomics>
struct NoteRay
{
  const Config* config;
  PointsOut points;
  std::int32_t*
      rays;  //!< [ring][bin], lowest slope of what was hit in that ring, as an ordered integer

  /** The range of bins of one thread. */
  Part part(int which, int of) const
  {
    const int bins = bin_count(*config);
    return {which * bins / of, (which + 1) * bins / of};
  }
  bool is_in(const Part& part, int point_i) const
  {
    const int bins = bin_count(*config), at = max_of(points.ray[point_i], 0);
    const int bin = at - floor_div(at, bins, 1.0f / static_cast<float>(bins)) * bins;
    return (bin >= part.begin) & (bin < part.end);
  }
  TALUS_HD void operator()(int point_i) const
  {
    const int at = points.ray[point_i];
    if (at >= 0) Atomics::min(rays + at, ordered_from_float(points.slope[point_i]));
  }
};

/** Enters how far the ray of a point went. */
template <class Atomics>
struct NoteReach
{
  PointsOut points;
  std::int32_t* reach;  //!< [bin][slope step], minus the greatest PointsOut::ray,
                        //!< which is the ray of the farthest ring; 0: no ray

  TALUS_HD void operator()(int point_i) const
  {
    if (points.reach[point_i] >= 0)
      Atomics::min(reach + points.reach[point_i], -points.ray[point_i]);
  }
};

/** Stage 1: transforms, accepts and weighs one point, and notes the ray that it ended. */
template <class Atomics>
struct AcceptPoint
{
  const Config* config;
  const FrameContext* frame;
  const Body* body;
  PointsIn in;
  PointsOut out;
  std::int32_t* rays;  //!< see NoteRay
  std::uint32_t* rejected;  //!< by RejectCode
  const std::uint8_t* voxel_kept;  //!< null: no voxel filter

  /** Computes what depends on this point alone. */
  TALUS_HD void locate(int point_i, const Point& sensed) const
  {
    const WindowPose pose = pose_of_point(*frame, in.time_s, point_i);
    put(point_i, sensed, pose, !voxel_kept || voxel_kept[point_i]);
    for (int box = 0; box < body->boxes; box++) drop_body(point_i, sensed, box);
  }

  /** Whether locate_plain() and then drop_body() of all boxes give the same as locate(): there is
   * no voxel filter and no motion during the scan. */
  TALUS_HD bool is_plain() const
  {
    return !voxel_kept && !(frame->n_poses > 1 && frame->has_times);
  }
  TALUS_HD void locate_plain(int point_i) const
  {
    put(point_i, in.at(point_i), frame->poses[0], true);
  }
  /** Rejects a located point, and its ray, if it is in that box of the body. */
  TALUS_HD void drop_body(int point_i, const Point& sensed, int box) const
  {
    const int code = static_cast<int>(out.reject[point_i]);
    const bool drop =
        is_in_box(sensed, *frame, *body, box) & (code != kNotFinite) & (code != kRange);
    out.reject[point_i] = static_cast<std::uint32_t>(select(drop, static_cast<int>(kBody), code));
    out.cell[point_i] = select(drop, -1, out.cell[point_i]);
    out.ray[point_i] = select(drop, -1, out.ray[point_i]);
    out.reach[point_i] = select(drop, -1, out.reach[point_i]);
  }

  /** Updates what the point shares with other points: counters and the table of rays. */
  TALUS_HD void note(int point_i) const
  {
    NoteRay<Atomics>{config, out, rays}(point_i);
    if (out.reject[point_i] != kAccepted) Atomics::count(rejected + out.reject[point_i]);
  }
  /** Counts the rejected among the points [begin, end), after locate(). */
  void count_rejected(int begin, int end) const
  {
    for (std::uint32_t code = 0; code < kRejectCodes; code++)
    {
      std::uint32_t n = 0;
      for (int point_i = begin; point_i < end; point_i++) n += out.reject[point_i] == code;
      if (n) Atomics::add(rejected + code, n);
    }
  }

 private:
  TALUS_HD void put(int point_i, const Point& sensed, const WindowPose& pose, bool kept) const
  {
    const Point p = transform(pose, sensed);
    const Verdict verdict = accept(sensed, rise_above_sensor(pose, sensed), *config);
    int code = select((verdict.seen != 0) & !kept, kVoxel, verdict.code);
    put_ray(point_i, p, (verdict.seen != 0) & kept);
    const float n = static_cast<float>(config->cells);
    const float cx = p.x_m * config->inverse_resolution, cy = p.y_m * config->inverse_resolution;
    const bool inside = (cx >= 0.0f) & (cx < n) & (cy >= 0.0f) & (cy < n);
    code = select((code == kAccepted) & !inside, kOutside, code);
    const int ix = floor_to_int(select(inside, cx, 0.0f));
    const int iy = floor_to_int(select(inside, cy, 0.0f));
    const int cell = storage_index(*frame, config->cells, ix, iy);
    out.cell[point_i] = select(code == kAccepted, cell, -1);
    out.reject[point_i] = static_cast<std::uint32_t>(code);
    out.height_m[point_i] = p.z_m;
    out.variance_m2[point_i] = point_variance(sensed.x_m, sensed.y_m, sensed.z_m, *config, *frame);
  }

  TALUS_HD void put_ray(int point_i, const Point& p, bool seen) const
  {
    const float dx = select(seen, p.x_m - frame->sensor_x_m, 0.0f);
    const float dy = select(seen, p.y_m - frame->sensor_y_m, 0.0f);
    const float chebyshev_m = chebyshev(dx, dy);
    const float ring = chebyshev_m * config->inverse_resolution;
    const bool aims = ring >= 1.0f;  // a ray straight up or down has no direction
    const int last_ring = frame->rings - 1;
    const float farthest = static_cast<float>(last_ring);
    const int row = floor_to_int(select(ring > farthest, farthest, ring));
    const int bins = bin_count(*config);
    const float direction =
        direction_in_bins(select(aims, dx, 1.0f), select(aims, dy, 0.0f), bins_per_side(*config));
    const int bin = wrap_bin(floor_to_int(direction), bins);
    out.ray[point_i] = select(aims, row * bins + bin, -1);
    const std::int32_t ray =
        ray_of(ray_slope(p.z_m - frame->sensor_z_map_m, chebyshev_m), chebyshev_m);
    const float slope = float_from_ordered(ray);
    out.slope[point_i] = slope;
    const float step = slope_step(select(aims, slope, 0.0f));
    const bool counts = aims & (step >= 0.0f) & (step < static_cast<float>(kSlopeSteps));
    const int at = bin * kSlopeSteps + floor_to_int(select(counts, step, 0.0f));
    out.reach[point_i] = select(counts, at, -1);
  }
};

}  // namespace talus::kernels
