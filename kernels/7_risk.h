#pragma once
#include "kernels/config.h"
#include "kernels/math.h"

namespace talus::kernels
{
/** The share of a standard normal distribution below z, to 3e-4 (Abramowitz and Stegun 7.1.27). */
TALUS_HD float normal_below(float z)
{
  const float x = min_of(abs_of(z) * 0.70710678f, 8.0f);
  const float p = 1.0f + x * (0.278393f + x * (0.230389f + x * (0.000972f + x * 0.078108f)));
  const float p2 = p * p, tail = 0.5f / (p2 * p2);
  return select(z < 0.0f, tail, 1.0f - tail);
}

/** What stage 7 and the stated variance say of a cell. */
struct RiskOfCell
{
  float slope, step, roughness, traversability;  //!< scores, see features_of()
  float variance_m2;
};

/** The probability that a cell is impassable, see talus::risk(). NaN where it was not judged. */
TALUS_HD float risk_of(const RiskOfCell& c, const Config& k)
{
  const float deviation_m = sqrtf(c.variance_m2);
  // The gradient of a plane through (2 r + 1)^2 heights with independent errors.
  const auto r = static_cast<float>(k.feature_radius_cells), side = 2.0f * r + 1.0f;
  const float spread_m = k.resolution_m * side * sqrtf(r * (r + 1.0f) / 3.0f);
  // Of step = (2 own - lowest - mean) / 2 with errors of own and lowest; of roughness that of own.
  constexpr float kStepErrors = 1.118f;  // sqrt(1 + 1/4)
  const float slope = c.slope / k.inverse_slope_threshold * spread_m / deviation_m;
  const float step = c.step / k.inverse_step_threshold / (kStepErrors * deviation_m);
  const float roughness = c.roughness / k.inverse_roughness_threshold / deviation_m;
  // A steep cell that is passable all the same is a step that the robot takes, or it drove there.
  const float climbs = select(c.slope > 0.0f, normal_below(slope), 1.0f);
  const float passable = climbs * normal_below(step) * normal_below(roughness);
  const float risk = select(c.traversability == 0.0f, 1.0f, clamp01(1.0f - passable));
  return select(is_known(c.traversability), risk, kNan);
}

}  // namespace talus::kernels
