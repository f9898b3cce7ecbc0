#pragma once
#include <talus/baselines/rolling_cells.h>

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

}  // namespace talus::baselines
