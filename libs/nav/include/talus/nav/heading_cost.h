#pragma once
#include <talus/map_view.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace talus::nav
{
/** A position seen from above. */
struct Point2
{
  /** In the map frame or in that of a robot. */
  double x_m, y_m;
};

/** A robot seen from above. */
struct Pose2
{
  /** Position and heading, counterclockwise from x; map frame. */
  double x_m, y_m, yaw_rad;

  /** A point of the map frame in that of the robot: x ahead, y left. */
  Point2 to_robot(const Point2& p) const
  {
    const double dx = p.x_m - x_m, dy = p.y_m - y_m, c = std::cos(yaw_rad), s = std::sin(yaw_rad);
    return {dx * c + dy * s, -dx * s + dy * c};
  }
};

/** The heading of a pose [rad]. */
inline double yaw_of(const Pose& T) { return std::atan2(T.m[4], T.m[0]); }
/** A pose seen from above. */
inline Pose2 from_above(const Pose& T) { return {T.x(), T.y(), yaw_of(T)}; }

/** A robot on its wheels, legs or tracks, in the frame of its base: x ahead, y left [m]. The
 * defaults are a Scout-mini, with the limits of the map's own thresholds. */
struct Footprint
{
  /** The rectangle of its body, seen from above. */
  double min_x_m = -0.31, max_x_m = 0.31, min_y_m = -0.29, max_y_m = 0.29;
  /** Where it touches the ground: three places or more, not on one line. */
  std::vector<Point2> wheels{{0.23, 0.24}, {0.23, -0.24}, {-0.23, 0.24}, {-0.23, -0.24}};
  double wheel_radius_m = 0.08;  //!< around such a place it rests on the ground
  double ground_clearance_m = 0.1;  //!< of its underside above the plane of its wheels
  /** From this tilt on it must not stand, along and across its heading [rad]. */
  double max_along_rad = 0.6, max_across_rad = 0.4;
  double max_step_m = 0.2;  //!< nor from this step under a wheel on

  /** How far a point of its frame is from its outline; 0 inside. */
  double outside_m(const Point2& p) const
  {
    return std::hypot(
        std::max({0.0, p.x_m - max_x_m, min_x_m - p.x_m}),
        std::max({0.0, p.y_m - max_y_m, min_y_m - p.y_m}));
  }
  /** From its base to its farthest corner. */
  double reach_m() const
  {
    return std::hypot(std::max(max_x_m, -min_x_m), std::max(max_y_m, -min_y_m));
  }
};

/** What the ground does with a robot at one place and heading. All NaN where the map does not know
 * the ground under a wheel. */
struct HeadingCost
{
  double along_rad;  //!< tilt of the plane through the wheels, positive: the front is higher
  double across_rad;  //!< positive: the left side is higher
  double step_m;  //!< the highest under a wheel, above and below that tilt
  /** The least height of the body's underside above what is below it; negative: it touches. Ground
   * that is not known counts for nothing. */
  double clearance_m;
  /** [0, 1]: the greatest of tilt, step and lacking clearance, each by its limit; 1: impassable.
   * Tilts along and across add up as the sides of a right angle, so a slope costs least straight.
   */
  double cost;
};

/** What a robot meets at a pose of the map frame, seen from above: its tilt, steps under its wheels
 * and the room under its body, of the higher of the two surfaces of each cell. So a robot may stand
 * along a slope that it could not cross, and over a stone between its wheels. What hangs higher
 * than the map's `clearance_m` is passable, as everywhere. Throws std::invalid_argument for a pose
 * that is not finite and a footprint without three wheels that span a plane or with a limit or side
 * that is not positive; as MapView::layer() does; and all NaN for an empty map. */
HeadingCost heading_cost(const MapView& map, const Footprint& robot, const Pose2& T_map_base);

}  // namespace talus::nav
