#pragma once
#include <vector>

#include "near_ground.h"

namespace talus::hints
{
/** A piece of a wall, frame of the map. */
struct WallLine
{
  double x_m, y_m, normal_x, normal_y;
};

/** What a frame with this pose shows. */
WallLine wall_line(const Facet& facet, double x_m, double y_m, double heading_rad);

/** How far the walls of frames lie apart. */
class WallsApart
{
 public:
  /** Each of the first frame from the nearest that is parallel of the second. */
  void add(const std::vector<WallLine>& first, const std::vector<WallLine>& second);
  /** What is farther than 0.3 m counts as that. NaN: there is too little to compare. */
  double mean_m() const;

 private:
  double sum_m_ = 0, count_ = 0;
};

}  // namespace talus::hints
