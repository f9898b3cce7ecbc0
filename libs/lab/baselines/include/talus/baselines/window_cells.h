#pragma once
#include <talus/baselines/method.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

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

  /** Index of the cell `step` steps from the sensor's; negative: behind it. -1: outside. */
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

/** The cells of a window that follows a robot: what stays inside is kept, what enters is as a new
 * Cell. Index = iy * window().cells + ix. */
template <class Cell>
class RollingCells
{
 public:
  const Window& window() const { return window_; }
  std::size_t size() const { return cells_.size(); }
  Cell& operator[](std::size_t i) { return cells_[i]; }
  const Cell& operator[](std::size_t i) const { return cells_[i]; }
  auto begin() { return cells_.begin(); }
  auto end() { return cells_.end(); }

  /** The cell of (x, y), nullptr outside. */
  Cell* find(double x_m, double y_m)
  {
    const int i = cell_index(window_, x_m, y_m);
    return i < 0 ? nullptr : &cells_[i];
  }

  void move_to(const Window& window)
  {
    const bool same = window.min_cell_x == window_.min_cell_x &&
                      window.min_cell_y == window_.min_cell_y && !cells_.empty();
    if (same) return;
    std::vector<Cell> moved(
        static_cast<std::size_t>(window.cells) * static_cast<std::size_t>(window.cells));
    for (int iy = 0; iy < window_.cells; ++iy)
      for (int ix = 0; ix < window_.cells; ++ix)
      {
        const std::int64_t x = ix + window_.min_cell_x - window.min_cell_x;
        const std::int64_t y = iy + window_.min_cell_y - window.min_cell_y;
        if (x < 0 || y < 0 || x >= window.cells || y >= window.cells) continue;
        moved[y * window.cells + x] = cells_[iy * window_.cells + ix];
      }
    cells_ = std::move(moved);
    window_ = window;
  }

 private:
  Window window_;
  std::vector<Cell> cells_;
};

/** Goes from the cells of `todo` to those of their four neighbours that `goes(from, to)` allows,
 * and on from there; marks in `reached` what it comes to. Index = iy * cells_x + ix. */
template <class Goes>
void spread(
    std::vector<int> todo, std::vector<std::uint8_t>& reached, int cells_x, const Goes& goes)
{
  const int size = static_cast<int>(reached.size());
  while (!todo.empty())
  {
    const int i = todo.back(), x = i % cells_x;
    todo.pop_back();
    for (int next : {x > 0 ? i - 1 : -1, x + 1 < cells_x ? i + 1 : -1, i - cells_x, i + cells_x})
    {
      if (next < 0 || next >= size || reached[next]) continue;
      if (!goes(static_cast<std::size_t>(i), static_cast<std::size_t>(next))) continue;
      reached[next] = 1;
      todo.push_back(next);
    }
  }
}

}  // namespace talus::baselines
