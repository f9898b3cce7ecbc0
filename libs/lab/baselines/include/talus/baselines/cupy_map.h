#pragma once
#include <talus/baselines/one_surface_map.h>

namespace talus::baselines
{
/** A robot-centric elevation map with one surface, after Miki et al. 2022 (the paper's CuPy):
 * - points in a cone above the sensor are left out: what hangs there is passed below;
 * - drift compensation: the map follows the mean height error of the points on flat cells;
 * - Kalman fusion; a point outside the Mahalanobis gate makes the cell less sure instead, and so
 *   does time;
 * - visibility cleanup in every frame;
 * - gaps: the min filter, then inpainting (Telea) of what it left.
 * Traversability by judge_one_surface(), in place of its trained network. It does not tell how far
 * a fill can be relied on: all count as filled from one side. */
class CuPyMap : public OneSurfaceMap
{
 public:
  explicit CuPyMap(const Parameters& parameters) : OneSurfaceMap(parameters) {}
  std::string name() const override { return "cupy"; }
  void update(const Frame& frame) override;
  Surfaces read() override;

 private:
  void grow_older(double stamp_s);
  void compensate_drift(const std::vector<MapPoint>& points);
  void fuse(Cell& cell, const MapPoint& p, double stamp_s) const;

  double last_stamp_s_ = 0;
};

}  // namespace talus::baselines
