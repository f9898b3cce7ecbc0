#include "close_islands.h"

#include "needed_layer.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <vector>

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
  Islands(const io::LayerStack& map, const Kinds& kinds)
      : width_(map.cells_x), height_(map.cells_y), kinds_(kinds), is_taken_(kinds.size())
  {
  }

  bool begins_at(std::size_t i) const { return kinds_[i] == Kind::Free && !is_taken_[i]; }

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
        island.touches_blocked |= kinds_[i] == Kind::Blocked;
        if (!begins_at(i)) continue;
        is_taken_[i] = true;
        next.push_back(i);
      }
  }

  int width_, height_;
  const Kinds& kinds_;
  std::vector<bool> is_taken_;
};
}  // namespace

Kinds kinds_of(const MapStrips& map, const Occupancy& o)
{
  const io::LayerStack& frame = map.frame();
  Kinds kinds(frame);
  std::size_t count = 0;
  map.for_each(
      [&](const Strip& strip)
      {
        for (const float t : needed_layer(strip.map, Layer::Traversability))
          kinds.set(
              count++, std::isnan(t)                 ? Kind::Unknown
                       : is_blocked(t, o.blocked_at) ? Kind::Blocked
                                                     : Kind::Free);
      });
  if (o.close_islands_m <= 0) return kinds;
  Islands islands(frame, kinds);
  for (std::size_t first = 0; first < kinds.size(); ++first)
  {
    if (!islands.begins_at(first)) continue;
    const Island island = islands.take(first, o.close_islands_m / frame.resolution_m);
    for (const std::size_t i : island.cells)
      kinds.set(i, island.touches_blocked ? Kind::Blocked : Kind::Unknown);
  }
  return kinds;
}

}  // namespace talus::formats
