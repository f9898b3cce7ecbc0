#pragma once
#include "kernels/frame.h"
#include "kernels/math.h"

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
  kBuried,
  kRejectCodes,
  kAccepted = kRejectCodes
};

struct FrameCounts
{
  std::uint32_t rejected[kRejectCodes];  //!< points by RejectCode
  std::uint32_t leaves_floor;  //!< 1: the frame shows another floor
};

struct Verdict
{
  int code;  //!< a RejectCode
  /** Whether its ray counts: also above the height band, since the space before it is free. */
  std::int32_t seen;
};

/** Stage 1 on one point of the sensor frame that lies `rise_m` above the sensor, along the map's z
 * (III-A.1): range and height band. The first reason in the order of the codes counts. */
TALUS_HD Verdict accept(const Point& p, float rise_m, const Config& k)
{
  const float range2 = p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m;
  const bool finite = is_finite(p.x_m) & is_finite(p.y_m) & is_finite(p.z_m);
  const bool in_range = (range2 >= k.min_range2_m2) & (range2 <= k.max_range2_m2);
  const bool in_band = (rise_m >= k.min_height_m) & (rise_m <= k.max_height_m);
  int code = select(in_band, kAccepted, kHeight);
  code = select(in_range, code, kRange);
  const std::int32_t seen = select(finite & in_range, 1, 0);
  return {select(finite, code, kNotFinite), seen};
}

TALUS_HD bool is_in_box(const Point& p, const FrameContext& f, const Body& body, int box)
{
  const float* m = f.T_base_sensor;
  const float x_m = m[0] * p.x_m + m[1] * p.y_m + m[2] * p.z_m + m[3];
  const float y_m = m[4] * p.x_m + m[5] * p.y_m + m[6] * p.z_m + m[7];
  const float z_m = m[8] * p.x_m + m[9] * p.y_m + m[10] * p.z_m + m[11];
  const float *low = body.min_m[box], *high = body.max_m[box];
  return (x_m >= low[0]) & (x_m <= high[0]) & (y_m >= low[1]) & (y_m <= high[1]) & (z_m >= low[2]) &
         (z_m <= high[2]);
}

TALUS_HD bool is_body(const Point& p, const FrameContext& f, const Body& body)
{
  bool any = false;
  for (int box = 0; box < body.boxes; box++) any |= is_in_box(p, f, body, box);
  return any;
}

TALUS_HD float rise_above_sensor(const WindowPose& pose, const Point& p)
{
  const float* m = pose.m;
  return m[8] * p.x_m + m[9] * p.y_m + m[10] * p.z_m;
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

/** The pose at a point's time (deskew): linear between the poses of the path, which lie so close
 * together that this is exact to rounding. */
TALUS_HD WindowPose pose_at(const FrameContext& f, float time_s)
{
  const float last = static_cast<float>(f.n_poses - 1);
  const float since_start = (time_s - f.path_start_s) * f.path_rate_hz;
  const float at = since_start > 0.0f ? min_of(since_start, last) : 0.0f;  // NaN: the first pose
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

TALUS_HD WindowPose pose_of_point(const FrameContext& f, const float* time_s, int point_i)
{
  const bool moves = f.n_poses > 1 && f.has_times;
  return moves ? pose_at(f, time_s[point_i]) : f.poses[0];
}

/** Stage 1 (III-A.2): variance of a point's height [m^2], sensor noise plus pose change: (c_beam +
 * a_beam l)^2 + (lambda_t l sin(theta/2))^2 with l the range in the sensor frame. */
TALUS_HD float point_variance(
    float x_m, float y_m, float z_m, const Config& k, const FrameContext& f)
{
  const float range2 = x_m * x_m + y_m * y_m + z_m * z_m;
  const float sensor = k.c_beam_m + k.a_beam * sqrtf(range2);
  return sensor * sensor + f.pose_change2 * range2;
}

}  // namespace talus::kernels
