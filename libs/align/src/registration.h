#pragma once
#include "field.h"
#include "pose.h"

#include <Eigen/Core>

#include <vector>

namespace talus::align
{
/** Directions in (x, y, turn), orthonormal. */
using Directions = std::vector<Eigen::Vector3d>;

/** A map and what it is laid onto. */
struct Task
{
  const Reference& reference;
  const Samples& samples;
  double pixel_m;
};

/** How well the map lies there, in samples: the sum over all of 0 to 1 each; ground that has
 * nothing to lie on counts as the others do, so that no overlap is sought for its own sake. Two
 * samples whose heights or places differ by `sigma_z_m` and `sigma_m` count 0.6. */
double score(const Task& task, const Pose& pose, double sigma_m, double sigma_z_m);

/** The median of what raises the samples to the ground there, and of how many. */
struct Height
{
  double median_m = 0;
  std::size_t count = 0;
};
Height height_at(const Task& task, const Pose& pose);

/** The places, anywhere in the reference, where most of what stands meets what stands there, one
 * for each quarter turn; none where that is little. */
std::vector<Pose> best_anywhere(const Task& task);

/** Turned around the middle of what tells the position, that of what stands there, else of all
 * ground; moved by `by_m` and turned by `turn_rad` around the origin before. */
Pose first_pose(const Task& task, double turn_rad, const Eigen::Vector2d& by_m = {0, 0});

/** The best place on a raster along `along`, up to 1.5 m and 7 degrees from `start`. */
Pose best_nearby(const Task& task, const Pose& start, const Directions& along);

/** From a place nearby to the best, without a move along `fixed`: Ceres with robust losses. */
Pose refined(const Task& task, const Pose& start, const Directions& fixed);

/** What a map is found to do. */
struct Registration
{
  Pose pose;
  Pose fine;  //!< of which `pose` is what moves whole pixels
  Directions unobservable;
  bool overlaps = true;
};
Registration registered(const Task& task);

}  // namespace talus::align
