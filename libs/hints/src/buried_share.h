#pragma once
#include <optional>
#include <vector>

#include "near_ground.h"

namespace talus::hints
{
/** Of pairs of points on the ground in one direction, one at least twice as far as the other: the
 * share in which the ray to the farther one runs into the nearer. It is about 0 where rays begin at
 * a sensor above the ground, however rough, and large where they begin in the ground. Nothing where
 * there are few pairs. Points of one frame and where its sensor is, in the frame of the base. */
std::optional<double> buried_share(
    const std::vector<Vec3>& points, const NearPlane& ground, const Vec3& sensor);

}  // namespace talus::hints
