#pragma once
#include <talus/formats/write.h>

#include <cstdint>
#include <vector>

namespace talus::formats
{
/** What a cell is to a planner. */
enum class Kind : std::uint8_t
{
  Unknown,
  Free,
  Blocked
};

/** Of each cell, four a byte: a large map has hundreds of millions. */
class Kinds
{
 public:
  explicit Kinds(const io::LayerStack& frame)
      : count_(static_cast<std::size_t>(frame.cells_x) * static_cast<std::size_t>(frame.cells_y)),
        bytes_(count_ / 4 + 1)
  {
  }
  std::size_t size() const { return count_; }
  Kind operator[](std::size_t i) const { return static_cast<Kind>(bytes_[i / 4] >> shift(i) & 3U); }
  void set(std::size_t i, Kind kind)
  {
    const unsigned others = bytes_[i / 4] & ~(3U << shift(i));
    bytes_[i / 4] = static_cast<std::uint8_t>(others | static_cast<unsigned>(kind) << shift(i));
  }

 private:
  static unsigned shift(std::size_t i) { return 2 * static_cast<unsigned>(i % 4); }
  std::size_t count_;
  std::vector<std::uint8_t> bytes_;
};

/** Free cells that hang together are closed where a square of
 * Occupancy::close_islands_m holds them: no robot of that size gets there. They become what is
 * around them, blocked where they touch a blocked cell, else unknown. */
Kinds kinds_of(const MapStrips& map, const Occupancy& o);

}  // namespace talus::formats
