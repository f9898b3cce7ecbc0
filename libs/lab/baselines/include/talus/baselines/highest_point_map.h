#pragma once
#include <talus/baselines/method.h>
#include <talus/baselines/one_surface_map.h>

namespace talus::baselines
{
/** Fills `traversability` the way grid filters do on one surface, `elevation_m`: in the square
 * neighbourhood of feature_radius_m, unknown cells left out,
 * - slope: angle of the least-squares plane, over slope_threshold_rad;
 * - step: greatest height difference to the cell, over step_threshold_m;
 * - roughness: RMS distance from that plane, over roughness_threshold_m;
 * and their weighted sum, zero where any is zero (eq. 13 with unsigned features). Fewer than three
 * known cells: slope and roughness count as perfect. */
void judge_one_surface(Surfaces& surfaces, const Parameters& parameters);

/** The same for maps with a ground below the elevation: slope and step on `ground_m`, and blocked
 * where the elevation stands more than step_threshold_m above the ground. */
void judge_two_surfaces(Surfaces& surfaces, const Parameters& parameters);

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
