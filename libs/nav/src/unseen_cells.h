#pragma once
#include <talus/nav/costmap.h>

#include <cstdint>
#include <set>
#include <utility>

namespace talus::nav
{
/** Remembers what blocked because it was not seen from nearby. From farther away it blocks no more,
 * and a robot without this memory turns back to it again and again. */
class UnseenCells
{
 public:
  /** `costmap` and the same one with more blocked, because it must have been seen by now. */
  void remember(const Pose2& robot, const Costmap& costmap, const Costmap& blocked);
  /** Blocks it on a costmap; false where nothing is left to block. */
  bool block(Costmap& costmap) const;

 private:
  /** Column and row, counted from the origin of the map. */
  std::set<std::pair<std::int64_t, std::int64_t>> cells_;
};

}  // namespace talus::nav
