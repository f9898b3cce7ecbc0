#pragma once
#include <talus/baselines/one_surface_map.h>

namespace talus::baselines
{
/** A robot-centric elevation map with one surface, after Fankhauser et al. 2018: Kalman fusion
 * inside a Mahalanobis gate of 2.5; above it the point replaces the height, below it is ignored;
 * once a second a visibility cleanup walks the line to each cell and erases what stands above.
 * Traversability by judge_one_surface(). */
class HighestPointMap : public OneSurfaceMap
{
 public:
  explicit HighestPointMap(const Parameters& parameters) : OneSurfaceMap(parameters) {}
  std::string name() const override { return "highest"; }
  void update(const Frame& frame) override;
  Surfaces read() override;

 protected:
  /** Points of the frame, without the cleanup. Returns them. */
  std::vector<MapPoint> insert(const Frame& frame);

 private:
  void fuse(Cell& cell, const MapPoint& p, double stamp_s) const;

  double last_cleanup_s_ = 0;
};

/** The same kind of map on a GPU, after Pan et al. 2019 (the paper's CuCpp): cleanup in every
 * frame; traversability half slope, half roughness, no step. */
class CuCppMap : public HighestPointMap
{
 public:
  explicit CuCppMap(const Parameters& parameters) : HighestPointMap(parameters) {}
  std::string name() const override { return "cucpp"; }
  void update(const Frame& frame) override;
  Surfaces read() override;
};

}  // namespace talus::baselines
