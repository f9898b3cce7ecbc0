#pragma once
#include <array>
#include <vector>

#include "directions.h"
#include "near_ground.h"

namespace talus::hints
{
/** How near to the sensor ground is seen in each direction. A body hides the ground between itself
 * and the sensor that it carries: where ground is seen before a thing, the thing stands apart. */
class GroundBefore
{
 public:
  /** Points of one frame and where the sensor is, in the frame of the base. */
  void add(const std::vector<Vec3>& points, const NearPlane& ground, const Vec3& sensor);

  /** Share of the frames that see ground between the sensor and what is at `p`. */
  double share_before(const Vec3& p, const Vec3& sensor) const;

 private:
  std::vector<std::array<float, kDirections>> nearest_m_;  //!< of each frame; infinite: none
};

}  // namespace talus::hints
