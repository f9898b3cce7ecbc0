#pragma once
#include <talus/nav/costmap.h>
#include <talus/nav/heading_cost.h>
#include <talus/nav/obstacles.h>

#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace talus::nav
{
/** A pose on the route of a robot. */
struct RoutePose
{
  /** See Pose2. */
  double x_m, y_m, yaw_rad;
  bool backwards;  //!< it comes there in reverse
  bool narrow;  //!< there is no room for detours
  bool tilted;  //!< what the ground does with the robot depends on its heading
};
/** From the pose of the robot on; empty where there is none. */
using Route = std::vector<RoutePose>;

/** A route for a robot that turns on the spot: to within 0.35 m of the goal [m], best to the goal
 * itself, along cells and 16 headings (A*). It keeps 4 cm away from what stands and 17 from edges,
 * and farther where there is room. It may lead over what is not known, and over what is in doubt
 * (see find_doubtful()) where there is no other. The same map gives the same route. Throws
 * std::invalid_argument for a pose or goal that is not finite or farther away than a costmap
 * reaches, for a robot that is too large for the cells (its corners 0.48 m from its
 * base for cells of 0.05 m), and as heading_cost() and classify_cells(). */
Route plan(
    const MapView& map, const Pose& T_map_base, const Point2& goal, const Footprint& robot,
    const ObstacleOptions& o = {});

/** The point on a route that lies `ahead_m` along it from the pose nearest to the robot; its end
 * when it is nearer. Not for an empty route. */
Point2 point_ahead(const Route& route, const Pose2& robot, double ahead_m);

/** The pose of a route nearest to the robot. */
std::size_t nearest_on(const Route& route, const Pose2& robot);

/** What the ground does with a robot at a pose, [0, 1]; 1: it must not stand there, NaN: that is
 * not known. */
using GroundCostAt = std::function<double(const Pose2&)>;

/** Plans again and again on a drive: its costmap grows with it, and it remembers what was not seen
 * from nearby. */
class Planner
{
 public:
  /** The costmap may be empty but for its resolution, or cover what is known of the world. Throws
   * as plan(). */
  Planner(const Footprint& robot, Costmap costmap, const ObstacleOptions& o = {});
  ~Planner();

  /** plan() of the map and of what was known before; false where there is no route. */
  bool plan(const MapView& map, const Pose& T_map_base, const Point2& goal);
  /** The same of costmap(), which the caller keeps up to date, and of the same one with what must
   * have been seen by now, and was not, blocked. */
  bool plan(
      const Pose2& robot, const Point2& goal, const Costmap& known,
      const GroundCostAt& ground_cost);

  /** What was planned last. */
  const Route& route() const;
  /** What is known of the ground. */
  Costmap& costmap();
  /** What is known of the ground. */
  const Costmap& costmap() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Takes a robot that stands, although there is a route, back along its own trail. What blocks it
 * may be something that left while it was below the beams of the scanner, and from farther back the
 * map sees that it is gone. */
class Retreat
{
 public:
  /** Where to go back to, in the frame of `at`, or nothing: go on. To be asked at each step in
   * which the robot has somewhere to go. */
  std::optional<Point2> target(double time_s, const Point2& at);

  /** The robot has nowhere to go: it is right to stand. */
  void rest(double time_s) { stands_since_s_ = time_s; }

 private:
  void follow(double time_s, const Point2& at);
  std::optional<Point2> position_behind(const Point2& at) const;

  std::vector<Point2> trail_;
  Point2 stands_at_{1e9, 1e9};
  double stands_since_s_ = 0, give_up_s_ = 0;
  std::optional<Point2> going_back_to_;
};

}  // namespace talus::nav
