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

  void add(const Span& span, double max_cells)
  {
    min_x = std::min(min_x, span.begin_x);
    end_x = std::max(end_x, span.end_x);
    min_y = std::min(min_y, span.y);
    end_y = std::max(end_y, span.y + 1);
    if (std::max(end_x - min_x, end_y - min_y) < max_cells)
      spans.push_back(span);
    else
      spans.clear();
  }
};

class Islands
{
 public:
  Islands(const io::LayerStack& map, const Kinds& kinds)
      : width_(map.cells_x), height_(map.cells_y), left_(kinds)
  {
  }

  bool begins_at(int x, int y) const { return at(x, y) == Kind::Free; }

  Island take(int x, int y, double max_cells)
  {
    Island island;
    std::vector<Span> next{take_span(x, y)};
    while (!next.empty())
    {
      const Span span = next.back();
      next.pop_back();
      look_around(span, island, next);
      island.add(span, max_cells);
    }
    return island;
  }

 private:
  Kind at(int x, int y) const { return left_[static_cast<std::size_t>(y) * width_ + x]; }

  Span take_span(int x, int y)
  {
    Span span{y, x, x};
    while (span.begin_x > 0 && begins_at(span.begin_x - 1, y)) --span.begin_x;
    while (span.end_x < width_ && begins_at(span.end_x, y)) ++span.end_x;
    for (x = span.begin_x; x < span.end_x; ++x)
      left_.set(static_cast<std::size_t>(y) * width_ + x, Kind::Unknown);
    return span;
  }

  void look_around(const Span& span, Island& island, std::vector<Span>& next)
  {
    const int end_x = std::min(span.end_x + 1, width_);
    for (int y = std::max(0, span.y - 1); y < std::min(height_, span.y + 2); ++y)
      for (int x = std::max(0, span.begin_x - 1); x < end_x; ++x)
      {
        const Kind kind = at(x, y);
        island.touches_blocked |= kind == Kind::Blocked;
        if (kind == Kind::Free) next.push_back(take_span(x, y));
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
  Islands islands(frame, kinds);
  for (int y = 0; y < frame.cells_y; ++y)
    for (int x = 0; x < frame.cells_x; ++x)
    {
      if (!islands.begins_at(x, y)) continue;
      const Island island = islands.take(x, y, o.close_islands_m / frame.resolution_m);
      const Kind kind = island.touches_blocked ? Kind::Blocked : Kind::Unknown;
      for (const Span& span : island.spans)
        for (int at = span.begin_x; at < span.end_x; ++at)
          kinds.set(static_cast<std::size_t>(span.y) * frame.cells_x + at, kind);
    }
  return kinds;
}

}  // namespace talus::formats
