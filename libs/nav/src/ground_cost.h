#pragma once
#include <talus/nav/heading_cost.h>

#include <vector>

namespace talus::nav
{
/** heading_cost() of a robot for places a tenth of a metre and headings a 16th turn apart, kept
 * until the map changes, and 0 at once where the ground around it is even. */
class GroundCost
{
 public:
  explicit GroundCost(const Footprint& robot);

  /** To be called after each change of the map. */
  void update(const MapView& map);
  /** [0, 1]; NaN where the map does not know the ground under a wheel. */
  double cost(const MapView& map, const Pose2& robot) const;

 private:
  struct Range
  {
    float low_m, high_m;
  };
  int block_of(double at_m, double origin_m) const;
  bool is_even(const Point2& robot) const;

  Footprint footprint_;
  int lines_;  //!< headings that differ: half of them, where it is the same forwards and backwards
  Window window_{};
  int blocks_ = 0;  //!< of cells, along each side of the window
  std::vector<Range> heights_;  //!< of each block
  int places_ = 0;  //!< along each side of the window
  mutable std::vector<float> costs_;  //!< of each place and heading; -1: not asked yet
};

}  // namespace talus::nav
