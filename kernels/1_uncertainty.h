#pragma once
#include "kernels/frame.h"
#include "kernels/math.h"

namespace talus::kernels
{
/** Stage 1 (III-A.2): variance of a point's height, sensor noise plus pose change,
 * (c_beam + a_beam l)^2 + (lambda_t l sin(theta/2))^2 with l the range of the point in the sensor
 * frame [m^2]. */
TALUS_HD float point_variance(
    float x_m, float y_m, float z_m, const Config& k, const FrameContext& f)
{
  const float range2 = x_m * x_m + y_m * y_m + z_m * z_m;
  const float sensor = k.c_beam_m + k.a_beam * sqrtf(range2);
  return sensor * sensor + f.pose_change2 * range2;
}

}  // namespace talus::kernels
