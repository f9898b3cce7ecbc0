#pragma once
#include <talus/baselines/method.h>

#include <algorithm>
#include <cmath>

namespace talus::baselines
{
/** The straight line of cells from the one under a sensor to another one, and on in both
 * directions: of its steps each goes one cell along x or y. */
class CellLine
{
 public:
  /** (to_ix, to_iy): a cell of the window. The sensor may be outside. */
  CellLine(const Window& window, const Pose& T_map_sensor, int to_ix, int to_iy)
      : cells_(window.cells),
        from_x_(cell_of(window, T_map_sensor.x(), window.min_cell_x)),
        from_y_(cell_of(window, T_map_sensor.y(), window.min_cell_y)),
        dx_(to_ix - from_x_),
        dy_(to_iy - from_y_),
        steps_(static_cast<int>(std::max(std::abs(dx_), std::abs(dy_)))),
        step_m_(std::hypot(dx_, dy_) / std::max(steps_, 1) * window.resolution_m)
  {
  }

  /** From the sensor's cell to the other one; 0: they are the same, and there is no line. */
  int steps() const { return steps_; }
  double step_m() const { return step_m_; }

  /** Index of the cell so many steps from the sensor's; negative: behind it. -1: outside. */
  int operator()(int step) const
  {
    const double t = static_cast<double>(step) / steps_;
    const auto ix = static_cast<int>(std::lround(from_x_ + t * dx_));
    const auto iy = static_cast<int>(std::lround(from_y_ + t * dy_));
    return ix < 0 || iy < 0 || ix >= cells_ || iy >= cells_ ? -1 : iy * cells_ + ix;
  }

 private:
  static double cell_of(const Window& window, double at_m, std::int64_t min_cell)
  {
    return std::floor(at_m / window.resolution_m) - static_cast<double>(min_cell);
  }

  int cells_;
  double from_x_, from_y_, dx_, dy_;
  int steps_;
  double step_m_;
};

}  // namespace talus::baselines
