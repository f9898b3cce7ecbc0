#pragma once
#include "planning_grid.h"
#include "lattice.h"
#include "simulated_robot.h"

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/math/TPoint2D.h>
#include <mrpt/math/TPose2D.h>
#include <talus/sim/world.h>

#include <vector>

namespace talus::nav
{
/** The way to the goal on a costmap that grows with the drive. */
class Route
{
 public:
  static constexpr double kBeyond_m = 20;
  static constexpr double kFarthest_m = 3000;  //!< from the origin: what OctoMap can hold

  /** The costmap covers start, goal and all that stands in the world, and is unknown. Throws
   * std::invalid_argument where that is too far away or too large. */
  Route(
      const sim::World& world, const mrpt::math::TPoint2D& start, const mrpt::math::TPoint2D& goal,
      double resolution_m, const RobotBody& body, GroundCostAt ground_cost);

  mrpt::maps::COccupancyGridMap2D& costmap() { return costmap_; }
  const mrpt::maps::COccupancyGridMap2D& costmap() const { return costmap_; }

  /** Makes the costmap reach as far around the robot as the map does. */
  void cover(const mrpt::math::TPose2D& robot);

  /** Plans anew on costmap(), or on it with more blocked for now. False when there is no way; the
   * old one is then gone. */
  bool plan(const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap);

  /** The same with kBeyond_m of unknown ground around costmap, robot and goal: a way around what
   * the costmap ends in. */
  bool plan_beyond(
      const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap);

  /** The place on the way that lies `ahead_m` along it from the place nearest to the robot; its
   * end when it is nearer. Only after plan() found a way. */
  mrpt::math::TPoint2D target(const mrpt::math::TPose2D& robot, double ahead_m) const;

  /** Begins where the robot was. */
  const std::vector<RoutePose>& way() const { return way_; }

 private:
  bool plan_with(
      const mrpt::maps::COccupancyGridMap2D& costmap, double around_m,
      const mrpt::math::TPose2D& robot);

  mrpt::maps::COccupancyGridMap2D costmap_;
  mrpt::math::TPoint2D goal_;
  Lattice lattice_;
  std::vector<RoutePose> way_;
};

}  // namespace talus::nav
