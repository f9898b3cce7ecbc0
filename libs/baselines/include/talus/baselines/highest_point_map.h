#pragma once
#include <talus/baselines/method.h>

namespace talus::baselines
{
/** A robot-centric elevation map with one surface, after Fankhauser et al. 2018: Kalman fusion
 * inside a Mahalanobis gate of 2.5; above it the point replaces the height, below it is ignored;
 * once a second a visibility cleanup walks the line to each cell and erases what stands above.
 * Traversability by judge_one_surface(). */
class HighestPointMap : public Method
{
 public:
  explicit HighestPointMap(const Parameters& parameters);
  std::string name() const override { return "highest"; }
  void update(const Frame& frame) override;
  Surfaces read() override;

 private:
  struct Cell
  {
    float height_m, variance_m2;
    double stamp_s;
  };
  void move_to(const Window& window);
  void fuse(Cell& cell, const MapPoint& p, double stamp_s) const;
  void clean_up(const Frame& frame, const std::vector<MapPoint>& points);
  void lower_bounds_along(
      const Pose& from, int to_ix, int to_iy, float to_z_m, std::vector<float>& bound_m) const;

  Parameters parameters_;
  Window window_;
  std::vector<Cell> cells_;
  double last_cleanup_s_ = 0;
};

}  // namespace talus::baselines
