#pragma once
#include <vector>

#include "base_points.h"
#include "thresholds.h"

namespace talus::hints
{
/** A plane that the points around the sensor lie on. */
struct NearPlane
{
  bool found = false;
  Vec3 normal{0, 0, 1};  //!< of length 1
  double offset_m = 0;  //!< dot(normal, p) of its points
  double rms_m = 0;  //!< distance of its points

  double distance_m(const Vec3& p) const { return dot(normal, p) - offset_m; }
  /** Where the z axis of the base meets it. */
  double height_at_base_m() const { return offset_m / normal.z; }
};

/** The plane of the lowest returns up to `far_m` around the sensor (of the highest, where `up` is
 * -1), no steeper against the base than 60 degrees; its normal points to where `up` does. Found
 * where more than `least_share` of the directions and distances show it, from several sides. Points
 * in the frame of the base. */
NearPlane lowest_plane(
    const std::vector<Vec3>& points, const Vec3& sensor, double up, double far_m = kFar_m,
    double least_share = kGroundShare);

/** Whether all points lie in one plane with the sensor, as those of a level 2D scan do: they show
 * no ground. */
bool is_flat_scan(const std::vector<Vec3>& points, const Vec3& sensor);

/** The plane, however steep, on which more than half of all points around the sensor lie with
 * nothing beyond it; its normal points to the sensor. */
NearPlane supporting_plane(const std::vector<Vec3>& points, const Vec3& sensor);

}  // namespace talus::hints
