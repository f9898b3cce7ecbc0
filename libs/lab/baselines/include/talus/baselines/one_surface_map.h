#pragma once
#include <talus/baselines/window_cells.h>

#include <limits>

namespace talus::baselines
{
/** What robot-centric elevation maps with one surface have in common: heights with a variance in a
 * window that rolls, points that are taken in one by one, in the order of the frame. */
class OneSurfaceMap : public Method
{
 public:
  explicit OneSurfaceMap(const Parameters& parameters) : parameters_(parameters) {}

 protected:
  struct Cell
  {
    /** NaN: unknown. */
    float height_m = std::numeric_limits<float>::quiet_NaN();
    float variance_m2 = std::numeric_limits<float>::quiet_NaN();
    double stamp_s = 0;  //!< of the last frame that changed the height

    bool known() const { return height_m == height_m; }
  };

  const Parameters& parameters() const { return parameters_; }
  RollingCells<Cell>& cells() { return cells_; }
  void roll_to(const Frame& frame);
  /** Sensor noise of a point. */
  float point_variance_m2(const MapPoint& p) const;
  /** Fuses a point that lies within the gate. */
  void kalman(Cell& cell, const MapPoint& p, double stamp_s) const;
  /** Visibility cleanup: the ray to the lowest point of each cell that was hit bounds the heights
   * of all cells before it. What was not hit in this frame and stands higher is erased. */
  void clean_up(const Frame& frame, const std::vector<MapPoint>& points);
  /** The heights, as elevation and as ground; not judged. */
  Surfaces surfaces() const;

 private:
  Parameters parameters_;
  RollingCells<Cell> cells_;
};

/** Fills `traversability` as grid filters do on one surface, `elevation_m`: in the square
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
  void update(const Frame& frame) override;
  Surfaces read() override;
};

/** A robot-centric elevation map with one surface, after Miki et al. 2022 (the paper's CuPy):
 * - points in a cone above the sensor are left out: what hangs there is passed below;
 * - drift compensation: the map follows the mean height error of the points on flat cells;
 * - Kalman fusion; a point outside the Mahalanobis gate makes the cell less sure instead, and so
 *   does time;
 * - visibility cleanup in every frame;
 * - gaps: the min filter, then inpainting (Telea) of what it left.
 * Traversability by judge_one_surface(), in place of its trained network. It does not say how far
 * a fill can be relied on: all count as filled from one side. */
class CuPyMap : public OneSurfaceMap
{
 public:
  explicit CuPyMap(const Parameters& parameters) : OneSurfaceMap(parameters) {}
  void update(const Frame& frame) override;
  Surfaces read() override;

 private:
  void grow_older(double stamp_s);
  void compensate_drift(const std::vector<MapPoint>& points);
  void fuse(Cell& cell, const MapPoint& p, double stamp_s) const;

  double last_stamp_s_ = 0;
};

}  // namespace talus::baselines
