#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
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

/** Of pairs of points on the ground in one direction, one at least twice as far as the other: the
 * share in which the ray to the farther one runs into the nearer. It is about 0 where rays begin at
 * a sensor above the ground, however rough, and large where they begin in the ground. Nothing where
 * there are few pairs. Points of one frame and where its sensor is, in the frame of the base. */
std::optional<double> buried_share(
    const std::vector<Vec3>& points, const NearPlane& ground, const Vec3& sensor);

constexpr std::size_t kDirections = 120;  // around a sensor

/** How far a point is from the sensor, in the plane of the base. */
inline double away_m(const Vec3& p, const Vec3& sensor)
{
  return std::hypot(p.x - sensor.x, p.y - sensor.y);
}

inline std::size_t direction_of(const Vec3& p, const Vec3& sensor)
{
  const double turn = std::atan2(p.y - sensor.y, p.x - sensor.x) / (2 * M_PI) + 0.5;
  return std::min(static_cast<std::size_t>(turn * kDirections), kDirections - 1);
}

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

/** A short piece of an upright surface, seen from above, in a level frame at the base: x ahead. */
struct Facet
{
  double x_m, y_m;  //!< its middle
  double normal_x, normal_y;  //!< of length 1, to either side
  double bearing_rad;  //!< direction from the sensor to it, against x
  double time_s;  //!< after the stamp; 0: not known
};

/** What a frame shows of walls and the like: where its points between knee and head lie in lines.
 * The longest first. `points` and `ground` in the frame of the base. */
std::vector<Facet> facets_of(
    const std::vector<Vec3>& points, const std::vector<float>& times_s, const NearPlane& ground,
    const Vec3& sensor, const Pose& T_map_base, std::size_t most);

/** Two groups of frames that a robot took in different directions of travel: a bit for each frame.
 */
struct FrameSplit
{
  std::uint64_t one = 0, other = 0;
};

/** How far the headings of a drive lie apart [rad]. Up to 64 poses, in the order of time. */
double heading_span_rad(const std::vector<Pose>& poses);

/** The third of the frames that heads farthest to one side against that to the other; and the third
 * that turns most to one side, for each metre driven, against that to the other: who follows on the
 * robot's path swings out of its place there. */
std::vector<FrameSplit> splits_by_heading(const std::vector<Pose>& poses);

/** A piece of a wall, frame of the map. */
struct WallLine
{
  double x_m, y_m, normal_x, normal_y;
};

/** What a frame with this pose shows. */
WallLine wall_line(const Facet& facet, double x_m, double y_m, double heading_rad);

/** How far pieces of walls lie apart, summed up; what is farther than 0.3 m counts as that. */
struct WallsApart
{
  double sum_m = 0, count = 0;

  /** Each of the first frame from the nearest that is parallel of the second. */
  void add(const std::vector<WallLine>& first, const std::vector<WallLine>& second);
  /** NaN: there is too little to compare. */
  double mean_m(double min_count = kMinCompared) const;
};

}  // namespace talus::hints
