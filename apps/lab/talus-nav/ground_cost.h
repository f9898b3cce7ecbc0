#pragma once
#include <mrpt/math/TPose2D.h>
#include <talus/mrpt/heading_cost.h>

#include <vector>

#include "map_source.h"
#include "simulated_robot.h"

namespace talus::nav
{
/** heading_cost() of a robot for places a tenth of a metre and headings a 16th turn apart, kept
 * until the map changes, and 0 at once where the ground around it is even. */
class GroundCost
{
 public:
  explicit GroundCost(const RobotBody& body);

  /** To be called after each change of the map. */
  void update(const MapView& map);
  /** [0, 1]; NaN where the map does not know the ground under a wheel. */
  double cost(const MapView& map, const mrpt::math::TPose2D& robot) const;

 private:
  struct Range
  {
    float low_m, high_m;
  };
  int block_of(double at_m, double origin_m) const;
  bool is_even(const mrpt::math::TPoint2D& robot) const;

  Footprint footprint_;
  double reach_m_;  //!< from the middle of the robot to its corners
  Window window_{};
  int blocks_ = 0;  //!< of cells, along each side of the window
  std::vector<Range> heights_;  //!< of each block
  int places_ = 0;  //!< along each side of the window
  mutable std::vector<float> costs_;  //!< of each place and heading; -1: not asked yet
};

/** What the outline of the robot keeps away from what it knows to be blocked. */
constexpr double kKeepAway_m = 0.1;
/** And from what stands there, where there is no room. */
constexpr double kKeepAwayWhereNarrow_m = 0.02;

/** How long [s] a robot may go on with these speeds, at most `most_s`: until one of the places is
 * nearer to its outline than kKeepAway_m, or where it is `narrow` and no edge than
 * kKeepAwayWhereNarrow_m. A robot that stands nearer to one already must not come nearer than that
 * to any. */
double clear_time_s(
    const std::vector<BlockedPlace>& places, const RobotBody& body, double v_mps, double w_radps,
    double most_s, bool narrow);

}  // namespace talus::nav
