#pragma once
#include <talus/baselines/method.h>

namespace talus::baselines
{
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

  /** The cell of a place, nullptr outside. */
  Cell* find(double x_m, double y_m)
  {
    const int i = cell_index(window_, x_m, y_m);
    return i < 0 ? nullptr : &cells_[static_cast<std::size_t>(i)];
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
        moved[static_cast<std::size_t>(y * window.cells + x)] =
            cells_[static_cast<std::size_t>(iy * window_.cells + ix)];
      }
    cells_ = std::move(moved);
    window_ = window;
  }

 private:
  Window window_;
  std::vector<Cell> cells_;
};

}  // namespace talus::baselines
