#pragma once
#include <Eigen/Core>

#include <vector>

#include "sketch.h"

namespace talus::align
{
/** A value on a grid between the middles of its pixels, and its slope. */
struct FieldValue
{
  double value = NAN;
  Eigen::Vector2d slope{0, 0};  //!< a metre
};

/** Bilinear; NaN beside unknown pixels and outside of the grid. */
FieldValue value_at(const cv::Mat1f& field, const Grid& grid, const Eigen::Vector2d& at_m);

/** How far something stands; inside of it negative, to 0.15 m. */
cv::Mat1f signed_distances_m(const cv::Mat1b& stands, double pixel_m);

/** 1 inside of what stands, 0 outside, and between over some pixels. */
cv::Mat1f blurred_edges(const cv::Mat1b& stands);

/** What the maps that lie already tell. */
class Reference
{
 public:
  explicit Reference(const Sketch& sketch);

  const Grid& grid() const { return grid_; }
  /** Height of the ground, smoothed against its noise; where it is level its slope is 0. */
  FieldValue ground(const Eigen::Vector2d& at_m) const;
  /** As it was measured, of the nearest pixel. */
  double ground_as_measured(const Eigen::Vector2d& at_m) const;
  /** How far something stands from there, of the nearest pixel; infinite outside of the grid. */
  double near_m(const Eigen::Vector2d& at_m) const;
  /** As blurred_edges(). */
  FieldValue edge(const Eigen::Vector2d& at_m) const { return value_at(edges_, grid_, at_m); }
  /** As signed_distances_m(); NaN outside of the grid. */
  FieldValue distance_m(const Eigen::Vector2d& at_m) const;

 private:
  Grid grid_;
  cv::Mat1f measured_m_, smooth_m_, distance_m_, edges_;
};

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

/** A place of a map at the edge of what stands. */
struct EdgeSample
{
  Eigen::Vector2d at_m;
  double blurred;
};

/** What is looked for in the others, evenly thinned to some thousands. */
struct Samples
{
  explicit Samples(const Sketch& sketch);

  std::vector<GroundSample> ground;
  std::vector<StandingSample> standing;
  std::vector<EdgeSample> edges;
};

}  // namespace talus::align
