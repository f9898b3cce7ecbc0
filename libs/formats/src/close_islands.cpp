#include "close_islands.h"

#include "needed_layer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace talus::formats
{
namespace
{
/** Free cells of a row, side by side. */
struct Span
{
  int y, begin_x, end_x;
};

/** Free cells that touch each other by a side or a corner. */
struct Island
{
  std::vector<Span> spans;  //!< none where it is too large to be closed
  int min_x = std::numeric_limits<int>::max(), end_x = 0, min_y = min_x, end_y = 0;
  bool touches_blocked = false;

  int side() const { return std::max(end_x - min_x, end_y - min_y); }
};

class Islands
{
 public:
  Islands(const Kinds& kinds, const io::LayerStack& map)
      : width_(map.cells_x), height_(map.cells_y), left_(kinds)
  {
  }

  bool begins_at(int x, int y) const { return left_[index(x, y)] == Kind::Free; }
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }

  Island take(int x, int y, double max_cells)
  {
    Island island;
    for (std::vector<Span> next{take_span(x, y)}; !next.empty();)
    {
      const Span span = next.back();
      next.pop_back();
      look_around(span, island, next);
      if (island.side() < max_cells)
        island.spans.push_back(span);
      else
        island.spans.clear();
    }
    return island;
  }

 private:
  Span take_span(int x, int y)
  {
    Span span{y, x, x};
    while (span.begin_x > 0 && begins_at(span.begin_x - 1, y)) --span.begin_x;
    while (span.end_x < width_ && begins_at(span.end_x, y)) ++span.end_x;
    for (x = span.begin_x; x < span.end_x; ++x) left_.set(index(x, y), Kind::Unknown);
    return span;
  }

  void look_around(const Span& span, Island& island, std::vector<Span>& next)
  {
    island.min_x = std::min(island.min_x, span.begin_x);
    island.end_x = std::max(island.end_x, span.end_x);
    island.min_y = std::min(island.min_y, span.y);
    island.end_y = std::max(island.end_y, span.y + 1);
    for (int y = std::max(0, span.y - 1); y < std::min(height_, span.y + 2); ++y)
      for (int x = std::max(0, span.begin_x - 1); x < std::min(width_, span.end_x + 1); ++x)
      {
        island.touches_blocked |= left_[index(x, y)] == Kind::Blocked;
        if (begins_at(x, y)) next.push_back(take_span(x, y));
      }
  }

  int width_, height_;
  Kinds left_;  //!< what was taken is unknown
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
  Islands islands(kinds, frame);
  for (int y = 0; y < frame.cells_y; ++y)
    for (int x = 0; x < frame.cells_x; ++x)
    {
      if (!islands.begins_at(x, y)) continue;
      const Island island = islands.take(x, y, o.close_islands_m / frame.resolution_m);
      for (const Span& span : island.spans)
        for (int at = span.begin_x; at < span.end_x; ++at)
          kinds.set(
              islands.index(at, span.y), island.touches_blocked ? Kind::Blocked : Kind::Unknown);
    }
  return kinds;
}

}  // namespace talus::formats
