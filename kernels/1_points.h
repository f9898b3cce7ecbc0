#pragma once
#include "kernels/1_accept.h"
#include "kernels/atomics.h"
#include "kernels/map.h"

namespace talus::kernels
{
struct Part
{
  int begin, end;
};

/** The rank of a point that lies in a cell but does not count. */
constexpr std::uint32_t kNoRank = ~0u;

template <class Atomics>
struct NoteRay
{
  const Map& m;

  Part part(int which, int of) const
  {
    const int bins = bin_count(m.k);
    return {which * bins / of, (which + 1) * bins / of};
  }
  bool is_in(const Part& part, int point_i) const
  {
    const int bins = bin_count(m.k), at = max_of(m.point_ray[point_i], 0);
    const int bin = at - floor_div(at, bins, 1.0f / static_cast<float>(bins)) * bins;
    return (bin >= part.begin) & (bin < part.end);
  }
  TALUS_HD void operator()(int point_i) const
  {
    const int at = m.point_ray[point_i];
    if (at >= 0) Atomics::min(m.rays + at, ordered_from_float(m.point_slope[point_i]));
  }
};

/** Enters how far the ray of a point went. */
template <class Atomics>
struct NoteReach
{
  const Map& m;

  TALUS_HD void operator()(int point_i) const
  {
    if (m.point_reach[point_i] >= 0)
      Atomics::max(m.reach + m.point_reach[point_i], m.point_ray[point_i]);
  }
};

/** Stage 1: transforms, accepts and weighs one point, and notes the ray that it ended. */
template <class Atomics>
struct AcceptPoint
{
  const Map& m;

  TALUS_HD void locate(int point_i, const Point& sensed) const
  {
    const WindowPose pose = pose_of_point(*m.frame, m.in.time_s, point_i);
    put(point_i, sensed, pose, !filters_voxels() || m.voxel_kept[point_i]);
    for (int box = 0; box < m.body->boxes; box++) drop_body(point_i, sensed, box);
  }

  /** Whether locate_plain() and then drop_body() of all boxes give the same as locate(): there is
   * no voxel filter and no motion during the scan. */
  TALUS_HD bool is_plain() const
  {
    return !filters_voxels() && !(m.frame->n_poses > 1 && m.frame->has_times);
  }
  TALUS_HD void locate_plain(int point_i) const
  {
    put(point_i, m.in.at(point_i), m.frame->poses[0], true);
  }
  /** Rejects a located point, and its ray, if it is in that box of the body. */
  TALUS_HD void drop_body(int point_i, const Point& sensed, int box) const
  {
    const int code = static_cast<int>(m.point_reject[point_i]);
    const bool drop =
        is_in_box(sensed, *m.frame, *m.body, box) & (code != kNotFinite) & (code != kRange);
    m.point_reject[point_i] =
        static_cast<std::uint32_t>(select(drop, static_cast<int>(kBody), code));
    m.point_cell[point_i] = select(drop, -1, m.point_cell[point_i]);
    m.point_ray[point_i] = select(drop, -1, m.point_ray[point_i]);
    m.point_reach[point_i] = select(drop, -1, m.point_reach[point_i]);
  }

  /** Updates what the point shares with other points: counters and the table of rays. */
  TALUS_HD void note(int point_i) const
  {
    NoteRay<Atomics>{m}(point_i);
    if (m.point_reject[point_i] != kAccepted)
      Atomics::count(m.counts->rejected + m.point_reject[point_i]);
  }
  void count_rejected(int begin, int end) const
  {
    for (std::uint32_t code = 0; code < kRejectCodes; code++)
    {
      std::uint32_t n = 0;
      for (int point_i = begin; point_i < end; point_i++) n += m.point_reject[point_i] == code;
      if (n) Atomics::add(m.counts->rejected + code, n);
    }
  }

 private:
  TALUS_HD bool filters_voxels() const { return m.k.inverse_voxel > 0; }
  TALUS_HD void put(int point_i, const Point& sensed, const WindowPose& pose, bool kept) const
  {
    const Point p = transform(pose, sensed);
    const Verdict verdict = accept(sensed, rise_above_sensor(pose, sensed), m.k);
    int code = select((verdict.seen != 0) & !kept, kVoxel, verdict.code);
    put_ray(point_i, p, (verdict.seen != 0) & kept);
    const float n = static_cast<float>(m.k.cells);
    const float cx = p.x_m * m.k.inverse_resolution, cy = p.y_m * m.k.inverse_resolution;
    const bool inside = (cx >= 0.0f) & (cx < n) & (cy >= 0.0f) & (cy < n);
    code = select((code == kAccepted) & !inside, kOutside, code);
    const int ix = floor_to_int(select(inside, cx, 0.0f));
    const int iy = floor_to_int(select(inside, cy, 0.0f));
    const int cell = m.at(ix, iy);
    m.point_cell[point_i] = select(code == kAccepted, cell, -1);
    m.point_reject[point_i] = static_cast<std::uint32_t>(code);
    m.point_height_m[point_i] = p.z_m;
    m.point_variance_m2[point_i] =
        point_variance(sensed.x_m, sensed.y_m, sensed.z_m, m.k, *m.frame);
  }

  TALUS_HD void put_ray(int point_i, const Point& p, bool seen) const
  {
    const float dx = select(seen, p.x_m - m.frame->sensor_x_m, 0.0f);
    const float dy = select(seen, p.y_m - m.frame->sensor_y_m, 0.0f);
    const float chebyshev_m = chebyshev(dx, dy);
    const float ring = chebyshev_m * m.k.inverse_resolution;
    const bool aims = ring >= 1.0f;  // a ray straight up or down has no direction
    const int last_ring = m.frame->rings - 1;
    const float farthest = static_cast<float>(last_ring);
    const int row = floor_to_int(select(ring > farthest, farthest, ring));
    const int bins = bin_count(m.k);
    const float direction =
        direction_in_bins(select(aims, dx, 1.0f), select(aims, dy, 0.0f), bins_per_side(m.k));
    const int bin = wrap_bin(floor_to_int(direction), bins);
    m.point_ray[point_i] = select(aims, row * bins + bin, -1);
    const std::int32_t ray =
        ray_of(ray_slope(p.z_m - m.frame->sensor_z_map_m, chebyshev_m), chebyshev_m);
    const float slope = float_from_ordered(ray);
    m.point_slope[point_i] = slope;
    const float slot = slope_bin(select(aims, slope, 0.0f));
    const bool counts = aims & (slot >= 0.0f) & (slot < static_cast<float>(kSlopeBins));
    const int at = bin * kSlopeBins + floor_to_int(select(counts, slot, 0.0f));
    m.point_reach[point_i] = select(counts, at, -1);
  }
};

}  // namespace talus::kernels
