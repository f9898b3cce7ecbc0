#pragma once
#include <talus/map_view.h>
#include <talus/nav/heading_cost.h>

#include <cstdint>
#include <vector>

namespace talus::nav
{
/** What a cell near the robot is of which nothing is known. */
enum class Unseen
{
  Obstacle,
  Free  //!< what is not known is left to the planner everywhere
};

/** What a cell in doubt is, see find_doubtful(): its ground may drop. */
enum class Drops
{
  Avoid,  //!< an obstacle, from afar unknown
  /** Free where a slope explains how far the measured ground on both sides of it falls: of half the
   * steepest that the robot climbs, and by no more than 2.5 of the highest step. */
  Slope,
  Ignore  //!< free
};

/** How the map becomes obstacles. Obstacles are not inflated: planners know the robot's shape. */
struct ObstacleOptions
{
  double blocked_at = 0.0;  //!< cells whose traversability is this or less are obstacles, [0,1]
  /** So are cells whose risk() is more than this, [0,1]; 1: none. Below 1 a snapshot needs the
   * layers that risk() reads. */
  double risk_at = 1.0;
  /** This near to the base, what is driven on must have been seen: a cell whose ground is unknown
   * or was not judged is what `unseen` says. With Unseen::Obstacle and Drops::Avoid a guess from
   * one side (CellState::FilledOneSided), and any guess up to 0.2 m beside what may drop, is an
   * obstacle, too: an edge may lie in it. Farther away it is left to the planner as unknown, and so
   * is what is in doubt, see find_doubtful(): from nearby it may look better. */
  double seen_within_m = 1.0;
  Unseen unseen = Unseen::Obstacle;  //!< what it is there without that
  Drops drops = Drops::Avoid;  //!< how bold the robot is where ground may drop
  double body_radius_m = 0.25;  //!< around the base nothing is an obstacle: it is in the robot
  double range_m = 5.0;  //!< obstacles farther from the base are left out, > 0
  double spacing_m = 0.1;  //!< one point a square of this side, that nearest to the base; 0: all
  bool boundary_only = true;  //!< only cells with a neighbour that is no obstacle
  double z_m = 0.1;  //!< height of the points of a robot in the plane, robot frame
};

/** What a cell is for a planner. */
enum class Passage : std::uint8_t
{
  Free,
  Unknown,  //!< not seen or in doubt, and not near
  Obstacle
};

/** What each cell of the window is, in the order of its layers. Throws std::invalid_argument for a
 * pose that is not finite and for an option that is NaN, no Unseen or no Drops; so do all functions
 * below that take them, of a map that is not empty. */
std::vector<Passage> classify_cells(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o);

/** Of the cells of the window, in the order of its layers: those that are blocked only by
 * comparison with filled ground, with nothing on it: perhaps a drop, perhaps the far side of a
 * crest. Seen from nearby they may look better. Those that `drops` makes free are not among them,
 * nor those in a gap of one cell between measured ground, which are free. */
std::vector<bool> find_doubtful(const MapView& map, const ObstacleOptions& o);

/** Of the obstacles, and of what is in doubt: the cells at which the ground may end, as it lies
 * more than a step below the base there, or as nothing stands within 0.2 m that would block. No
 * part of a robot should come near to them, while it may pass closely by a wall. */
std::vector<bool> find_edges(
    const MapView& map, const Pose& T_map_base, const std::vector<Passage>& cells);

/** A point of an obstacle. */
struct ObstaclePoint
{
  /** In the frame of the robot seen from above: x ahead, y left. */
  float x_m, y_m, z_m;
};

/** The obstacles among cells that classify_cells() judged, in the frame of the robot seen from
 * above (only the yaw of the base counts): for a robot in the plane (no `prism_heights_m`) all at
 * the height z_m. For a robot that is a pile of prisms of these heights [m], the lowest first: a
 * point in the middle of each prism that the obstacle reaches from the ground under it. So a slope
 * below the obstacle does not count, and what is higher than the robot is cut. What blocks without
 * standing on the ground (a steep slope, a ditch) is as high as the lowest prism. */
std::vector<ObstaclePoint> find_obstacles(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o,
    const std::vector<Passage>& cells, const std::vector<double>& prism_heights_m = {});

/** How far [m] the ground is known along the arc on which a command leads the base: up to the first
 * cell that is unknown, not judged or doubtful in a corridor of this width, the end of the window
 * or range_m. What lies within body_radius_m does not count, nor what is known to be an obstacle:
 * that is given to the planner. range_m for a robot that turns on the spot or stands, and of an
 * empty map 0. What `drops` makes free counts as known: with Drops::Avoid it tells how far the
 * ground was seen, beyond which a robot should creep. */
double known_ahead_m(
    const MapView& map, const Pose& T_map_base, double v_mps, double w_radps, double width_m,
    const ObstacleOptions& o);

/** The speed [m/s] from which a robot that reacts after `reaction_s` and brakes with
 * `deceleration_mps2` (> 0) stops within a distance; 0 where that is not positive. */
double stopping_speed_mps(double distance_m, double reaction_s, double deceleration_mps2);

}  // namespace talus::nav
