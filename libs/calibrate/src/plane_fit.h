#pragma once
#include <talus/calibrate/noise_model.h>
#include <talus/calibrate/patch.h>

#include <vector>

namespace talus::calibrate
{
/** A point in the map that may lie on a patch. */
struct Hit
{
  std::uint64_t cell = 0;
  std::uint32_t view = 0, point = 0;
  int frame = 0;
  float half_turn = 0;
  Eigen::Vector3f at_m;  //!< map frame
  Eigen::Vector3f beam;  //!< unit vector from the sensor
  float range_m = 0;

  /** Where its beam meets the ground, as far as known: its place but for the error along the beam.
   * Points are dealt out by it; by where they seem to be, each patch would get from beyond its
   * borders those that err towards it. */
  Eigen::Vector2f on_ground_m;

  Eigen::Vector2d offset(const Eigen::Vector2d& center_m) const
  {
    return at_m.head<2>().cast<double>() - center_m;
  }
};

/** Points of one cell. */
using Hits = std::vector<const Hit*>;

/** A plane through the ground of a cell, found against what stands on it. */
struct PlaneFit
{
  Plane plane = Plane::Zero();
  bool solved = false;
  double weighted_squares = 0;  //!< of the distances by their deviations, robust
  std::vector<float> sigma_m, cosine, distance_m;  //!< one a point
};
PlaneFit fit_plane(const Hits& hits, const Eigen::Vector2d& center_m, const NoiseModel& noise);

/** Where the beam of a point at this distance from the plane meets it. */
Eigen::Vector2d beam_on_plane(const Hit& hit, double distance_m, const Plane& plane);

/** Sum of the robust squares of these distances with the weights of `fit`; of points `which`. */
double robust_squares(double distance_m, double sigma_m);

}  // namespace talus::calibrate
