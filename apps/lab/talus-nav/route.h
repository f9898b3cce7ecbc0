#pragma once
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/math/TPoint2D.h>
#include <mrpt/math/TPose2D.h>
#include <talus/sim/world.h>

#include <vector>

namespace talus::nav
{
/** The way to the goal on a costmap that grows with the drive, by mrpt::nav::PlannerSimple2D. */
class Route
{
 public:
  static constexpr float kBlocked =
      0.45F;  //!< cells whose probability of being free is this or less
  /** Where nothing is known a way may be hoped for. What costmap_from_map() makes of a cell that is
   * known and not blocked is 0.55 or more. */
  static constexpr float kHopeful = 0.5F;
  static constexpr double kBeyond_m = 20;
  static constexpr double kFarthest_m = 3000;  //!< from the origin: what OctoMap can hold

  /** The costmap covers start, goal and all that stands in the world, and is unknown. Throws
   * std::invalid_argument where that is too far away or too large. */
  Route(
      const sim::World& world, const mrpt::math::TPoint2D& start, const mrpt::math::TPoint2D& goal,
      double resolution_m, double robot_radius_m);

  mrpt::maps::COccupancyGridMap2D& costmap() { return costmap_; }
  const mrpt::maps::COccupancyGridMap2D& costmap() const { return costmap_; }

  /** Makes the costmap reach as far around the robot as the map does. */
  void cover(const mrpt::math::TPose2D& robot);

  /** Plans anew on costmap(), or on it with more blocked for now. False when there is no way; the
   * old one is then gone. */
  bool plan(const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap);

  /** The same with kBeyond_m of unknown ground around costmap, robot and goal: a way around what
   * the costmap ends in. Its cells are twice as long. */
  bool plan_beyond(
      const mrpt::math::TPose2D& robot, const mrpt::maps::COccupancyGridMap2D& costmap);

  /** The place on the way that lies `ahead_m` along it from the place nearest to the robot; its
   * end when it is nearer. Only after plan() found a way. */
  mrpt::math::TPoint2D target(const mrpt::math::TPose2D& robot, double ahead_m) const;

  const std::vector<mrpt::math::TPoint2D>& way() const { return way_; }

 private:
  bool plan_with(
      const mrpt::maps::COccupancyGridMap2D& costmap, const mrpt::math::TPose2D& robot,
      double radius_m, const mrpt::math::TPoint2D& to);
  mrpt::math::TPoint2D before_goal(const mrpt::math::TPose2D& robot) const;

  mrpt::maps::COccupancyGridMap2D costmap_;
  mrpt::math::TPoint2D goal_;
  double robot_radius_m_;
  std::vector<mrpt::math::TPoint2D> way_;
};

}  // namespace talus::nav
