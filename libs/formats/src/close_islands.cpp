#include "close_islands.h"

#include "needed_layer.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

namespace talus::formats
{
namespace
{
/** Free cells that touch each other by a side or a corner. */
struct Island
{
  std::vector<std::size_t> cells;  //!< none where it is too large to be closed
  int min_x = std::numeric_limits<int>::max(), max_x = 0, min_y = min_x, max_y = 0;
  bool touches_blocked = false;

  int side() const { return std::max(max_x - min_x, max_y - min_y) + 1; }
};

class Islands
{
 public:
  Islands(const io::LayerStack& map, double blocked_at)
      : width_(map.cells_x),
        height_(map.cells_y),
        blocked_at_(blocked_at),
        score_(needed_layer(map, Layer::Traversability)),
        is_taken_(score_.size())
  {
  }

  bool begins_at(std::size_t i) const { return is_free(i) && !is_taken_[i]; }

  Island take(std::size_t first, double most_cells)
  {
    Island island;
    std::deque<std::size_t> next{first};
    is_taken_[first] = true;
    for (; !next.empty(); next.pop_front())
    {
      look_around(next.front(), island, next);
      if (island.side() < most_cells)
        island.cells.push_back(next.front());
      else
        island.cells.clear();
    }
    return island;
  }

 private:
  bool is_free(std::size_t i) const
  {
    return !std::isnan(score_[i]) && !is_blocked(score_[i], blocked_at_);
  }
  void look_around(std::size_t at, Island& island, std::deque<std::size_t>& next)
  {
    const auto row = static_cast<std::size_t>(width_);
    const int x = static_cast<int>(at % row), y = static_cast<int>(at / row);
    island.min_x = std::min(island.min_x, x);
    island.max_x = std::max(island.max_x, x);
    island.min_y = std::min(island.min_y, y);
    island.max_y = std::max(island.max_y, y);
    for (int ny = std::max(0, y - 1); ny <= std::min(height_ - 1, y + 1); ++ny)
      for (int nx = std::max(0, x - 1); nx <= std::min(width_ - 1, x + 1); ++nx)
      {
        const std::size_t i = static_cast<std::size_t>(ny) * row + static_cast<std::size_t>(nx);
        island.touches_blocked |= !std::isnan(score_[i]) && !is_free(i);
        if (!begins_at(i)) continue;
        is_taken_[i] = true;
        next.push_back(i);
      }
  }

  int width_, height_;
  double blocked_at_;
  const std::vector<float>& score_;
  std::vector<bool> is_taken_;
};
}  // namespace

std::vector<float> without_islands(const io::LayerStack& map, double blocked_at, double smallest_m)
{
  std::vector<float> score = needed_layer(map, Layer::Traversability);
  if (smallest_m <= 0) return score;
  Islands islands(map, blocked_at);
  for (std::size_t first = 0; first < score.size(); ++first)
  {
    if (!islands.begins_at(first)) continue;
    const Island island = islands.take(first, smallest_m / map.resolution_m);
    const float closed = island.touches_blocked ? 0.0F : std::numeric_limits<float>::quiet_NaN();
    for (const std::size_t i : island.cells) score[i] = closed;
  }
  return score;
}

}  // namespace talus::formats
