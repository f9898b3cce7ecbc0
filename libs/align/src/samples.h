#pragma once
#include "sketch.h"

#include <Eigen/Core>

#include <vector>

namespace talus::align
{
/** A place of a map where the ground was measured. */
struct GroundSample
{
  Eigen::Vector2d at_m;
  double height_m;
};

/** A place of a map where something stands. */
struct StandingSample
{
  Eigen::Vector2d at_m;
  double distance_m;  //!< from its edge, as signed_distances_m()
  bool is_line;  //!< a wall goes through it, which tells nothing along it
  Eigen::Vector2d normal;  //!< of the wall
};

/** What is looked for in the others, evenly thinned to some thousands. */
struct Samples
{
  explicit Samples(const Sketch& sketch);

  std::vector<GroundSample> ground;
  std::vector<StandingSample> standing;
};

}  // namespace talus::align
