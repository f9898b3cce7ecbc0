#pragma once
#include <vector>

#include "near_ground.h"

namespace talus::hints
{
/** A short piece of an upright surface, seen from above, in a level frame at the base: x ahead. */
struct Facet
{
  double x_m, y_m;  //!< its middle
  double normal_x, normal_y;  //!< of length 1, to either side
  double bearing_rad;  //!< direction from the sensor to it, against x
};

/** What a frame shows of walls and the like: where its points between knee and head lie in lines.
 * The longest first. `points` and `ground` in the frame of the base. */
std::vector<Facet> facets_of(
    const std::vector<Vec3>& points, const NearPlane& ground, const Vec3& sensor,
    const Pose& T_map_base, std::size_t most);

}  // namespace talus::hints
