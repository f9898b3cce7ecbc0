#pragma once
#include "kernels/atomics.h"
#include "kernels/rays.h"
#include "kernels/2_uncertainty.h"

namespace talus::kernels
{
/** Why a point is not accepted; the values of talus::Reject. */
enum RejectCode : int
{
  kNotFinite = 0,
  kRange,
  kHeight,
  kBody,
  kOutside,
  kVoxel,
  kRejectCodes,
  kAccepted = kRejectCodes
};

struct Point
{
  float x_m, y_m, z_m;
};

/** Stage 1 on one point of the sensor frame (III-A.1): range, the robot's body, the height band. */
TALUS_HD RejectCode accept(const Point& p, const Config& k)
{
  const float range2 = p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m;
  if (!is_finite(p.x_m) || !is_finite(p.y_m) || !is_finite(p.z_m)) return kNotFinite;
  if (!(range2 >= k.min_range2_m2 && range2 <= k.max_range2_m2)) return kRange;
  if (k.has_body && p.x_m >= k.body_min_m[0] && p.x_m <= k.body_max_m[0] &&
      p.y_m >= k.body_min_m[1] && p.y_m <= k.body_max_m[1] && p.z_m >= k.body_min_m[2] &&
      p.z_m <= k.body_max_m[2])
    return kBody;
  if (p.z_m < k.min_height_m || p.z_m > k.max_height_m) return kHeight;
  return kAccepted;
}

/** Eq. 1: sensor frame to window frame. */
TALUS_HD Point transform(const WindowPose& pose, const Point& p)
{
  const float* m = pose.m;
  return {
      m[0] * p.x_m + m[1] * p.y_m + m[2] * p.z_m + m[3],
      m[4] * p.x_m + m[5] * p.y_m + m[6] * p.z_m + m[7],
      m[8] * p.x_m + m[9] * p.y_m + m[10] * p.z_m + m[11]};
}

/** The pose at a point's time: linear between the path's poses, which lie so close together that
 * this is exact to rounding (deskew). */
TALUS_HD WindowPose pose_at(const FrameContext& f, float time_s)
{
  const float last = static_cast<float>(f.n_poses - 1);
  const float at = min_of(max_of((time_s - f.path_start_s) * f.path_rate_hz, 0.0f), last);
  const int before = min_of(floor_to_int(at), f.n_poses - 2);
  const float w = at - static_cast<float>(before);
  WindowPose pose;
  for (int i = 0; i < 12; i++)
  {
    const float a = f.poses[before].m[i], b = f.poses[before + 1].m[i];
    pose.m[i] = a + w * (b - a);
  }
  return pose;
}

/** The points of a frame, sensor frame, one array a coordinate. */
struct PointsIn
{
  const float* x_m;
  const float* y_m;
  const float* z_m;
  const float* time_s;  //!< read only where FrameContext::has_times
};

/** What stages 1 and 2 leave of each point. */
struct PointsOut
{
  std::int32_t* cell;  //!< storage index, or -1: not in the map
  std::uint32_t* rank;  //!< place among the points of its cell, in any order
  float* height_m;  //!< map frame
  float* variance_m2;
};

/** Stages 1 and 2: transforms, accepts, weighs and bins one point, and notes the ray that it ended.
 */
template <class Atomics>
struct AcceptPoint
{
  const Config* config;
  const FrameContext* frame;
  PointsIn in;
  PointsOut out;
  std::uint32_t* cell_count;  //!< by storage index, zero before
  std::int32_t*
      rays;  //!< [ring][bin], lowest slope of what was hit in that ring, as an ordered integer
  std::uint32_t* rejected;  //!< by RejectCode
  const std::uint8_t* voxel_kept;  //!< null: no voxel filter

  TALUS_HD void operator()(int i) const
  {
    if (i >= frame->n_points) return;
    out.cell[i] = -1;
    const RejectCode code = bin(i);
    if (code != kAccepted) Atomics::add(rejected + code, 1);
  }

 private:
  TALUS_HD RejectCode bin(int i) const
  {
    const Point sensed{in.x_m[i], in.y_m[i], in.z_m[i]};
    const RejectCode code = accept(sensed, *config);
    if (code != kAccepted && code != kHeight) return code;
    if (voxel_kept && !voxel_kept[i]) return kVoxel;

    const Point p = frame->n_poses > 1 && frame->has_times
                        ? transform(pose_at(*frame, in.time_s[i]), sensed)
                        : transform(frame->poses[0], sensed);
    note_ray(p);
    if (code != kAccepted) return code;
    return put_in_cell(i, sensed, p);
  }

  /** A point outside the height band or the window still says that the space before it is free. */
  TALUS_HD void note_ray(const Point& p) const
  {
    const float dx = p.x_m - frame->sensor_x_m, dy = p.y_m - frame->sensor_y_m;
    const float chebyshev_m = max_of(abs_of(dx), abs_of(dy));
    const float ring = chebyshev_m * config->inverse_resolution;
    if (ring < 1.0f) return;  // straight above or below: no direction
    const int last_ring = ring_count(*config) - 1;
    const int row = ring < static_cast<float>(last_ring) ? floor_to_int(ring) : last_ring;
    const int bins = bin_count(*config);
    const int bin = wrap_bin(floor_to_int(direction_in_bins(dx, dy, bins_per_side(*config))), bins);
    const float slope = ray_slope(p.z_m - frame->sensor_z_m, chebyshev_m);
    Atomics::min(rays + row * bins + bin, ordered_from_float(slope));
  }

  TALUS_HD RejectCode put_in_cell(int i, const Point& sensed, const Point& p) const
  {
    const float n = static_cast<float>(config->cells);
    const float cx = p.x_m * config->inverse_resolution, cy = p.y_m * config->inverse_resolution;
    if (!(cx >= 0.0f && cx < n && cy >= 0.0f && cy < n)) return kOutside;
    const int cell = storage_index(*frame, config->cells, floor_to_int(cx), floor_to_int(cy));
    out.height_m[i] = p.z_m;
    out.variance_m2[i] = point_variance(sensed.x_m, sensed.y_m, sensed.z_m, *config, *frame);
    out.rank[i] = Atomics::add(cell_count + cell, 1);
    out.cell[i] = cell;
    return kAccepted;
  }
};

// ---- Optional voxel filter
// ----------------------------------------------------------------------------------------- One
// point a voxel. Which one must not depend on the order of the points: the one whose coordinates
// mix to the smallest number. Two passes over an open-addressing table of voxels.

constexpr std::uint64_t kNoVoxel = ~0ull;

TALUS_HD std::uint64_t mix_bits(std::uint64_t v)
{
  v ^= v >> 30;
  v *= 0xbf58476d1ce4e5b9ull;
  v ^= v >> 27;
  v *= 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}

struct VoxelTable
{
  std::uint64_t* key;  //!< kNoVoxel before
  std::uint64_t* winner;  //!< kNoVoxel before
  std::uint32_t mask;  //!< size - 1, a power of two at least twice the points
};

/** Enters one point into the table; `slot` remembers where. */
template <class Atomics>
struct EnterVoxel
{
  const Config* config;
  const FrameContext* frame;
  PointsIn in;
  VoxelTable table;
  std::uint32_t* slot;

  TALUS_HD void operator()(int i) const
  {
    if (i >= frame->n_points) return;
    const Point p{in.x_m[i], in.y_m[i], in.z_m[i]};
    if (accept(p, *config) != kAccepted) return;
    const std::uint64_t key = voxel_key(p);
    std::uint32_t s = static_cast<std::uint32_t>(mix_bits(key)) & table.mask;
    for (;;)
    {
      const std::uint64_t there = Atomics::compare_exchange(table.key + s, kNoVoxel, key);
      if (there == kNoVoxel || there == key) break;
      s = (s + 1) & table.mask;
    }
    slot[i] = s;
    Atomics::min(table.winner + s, fingerprint(p));
  }

  /** 21 bits a coordinate, sensor frame. */
  TALUS_HD std::uint64_t voxel_key(const Point& p) const
  {
    constexpr std::uint64_t mask = (1u << 21) - 1;
    const auto part = [&](float v)
    { return static_cast<std::uint64_t>(floor_to_int(v * config->inverse_voxel)) & mask; };
    return part(p.x_m) << 42 | part(p.y_m) << 21 | part(p.z_m);
  }

  static TALUS_HD std::uint64_t fingerprint(const Point& p)
  {
    const auto bits = [](float v)
    { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(ordered_from_float(v))); };
    return mix_bits(mix_bits(bits(p.x_m) << 32 | bits(p.y_m)) ^ bits(p.z_m));
  }
};

/** Keeps the points that stand for their voxel. */
template <class Atomics>
struct KeepVoxel
{
  EnterVoxel<Atomics> entered;
  std::uint8_t* kept;

  TALUS_HD void operator()(int i) const
  {
    if (i >= entered.frame->n_points) return;
    const Point p{entered.in.x_m[i], entered.in.y_m[i], entered.in.z_m[i]};
    kept[i] = accept(p, *entered.config) != kAccepted ||
              entered.table.winner[entered.slot[i]] == EnterVoxel<Atomics>::fingerprint(p);
  }
};

}  // namespace talus::kernels
