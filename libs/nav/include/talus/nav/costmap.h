#pragma once
#include <talus/nav/obstacles.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace talus::nav
{
/** @name What the cells of a costmap mean
 * Probabilities of being free: 0.55 + 0.4 * traversability, and less of what blocks. @{ */
constexpr float kObstacle = 0.05F;  //!< something stands there
constexpr float kStandsBelow = 0.075F;  //!< in cells of less than this something stands
constexpr float kDropsFromNearby = 0.1F;  //!< in doubt, and it stayed so from within seen_within_m
constexpr float kEdge = 0.15F;  //!< blocked though nothing stands there
constexpr float kMayDrop = 0.2F;  //!< in doubt, see find_doubtful()
/** What of this or more is blocked lies beside something that stands. */
constexpr float kBesideAbove = 0.225F;
constexpr float kMayDropBesideWall = 0.25F;  //!< the same beside what stands
constexpr float kDropsFromNearbyBesideWall = 0.3F;  //!< the same beside what stands
constexpr float kBlockedUpTo = 0.45F;  //!< cells of this or less are blocked
constexpr float kHopeful = 0.5F;  //!< nothing is known
constexpr float kJustFree = 0.55F;  //!< with a traversability of 0
/** @} */

/** A rectangle of cells of the map frame, with the probability of each to be free. */
struct Costmap
{
  double resolution_m = 0;  //!< side of a cell, that of the map
  /** The first cell, counted from the map's origin. */
  std::int64_t min_cell_x = 0, min_cell_y = 0;
  /** Number of cells along x and y. */
  int columns = 0, rows = 0;
  std::vector<float> free;  //!< row by row, from the south

  /** Grows to hold a rectangle [m] of the map frame; new cells are kHopeful. Throws
   * std::invalid_argument for more than forty million cells. */
  void cover(double min_x_m, double max_x_m, double min_y_m, double max_y_m);
  /** The index of a cell. */
  std::size_t index(int column, int row) const
  {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  /** Left border, map frame [m]. */
  double min_x_m() const { return static_cast<double>(min_cell_x) * resolution_m; }
  /** Lower border, map frame [m]. */
  double min_y_m() const { return static_cast<double>(min_cell_y) * resolution_m; }
};

/** The probability of each cell of the window to be free, in the order of its layers; NaN where it
 * is not known. `range_m` does not count. */
std::vector<float> free_probabilities(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o);
/** What a cell of a costmap becomes that was `before`, when the map says `now`: what is known
 * replaces what was there, but what stayed in doubt from nearby stays so. */
float updated(float before, float now);
/** What a cell becomes when what is in doubt is passable: that which did not stay so from nearby.
 */
float admitted(float before);

/** A costmap of the window. */
Costmap costmap_from_map(const MapView& map, const Pose& T_map_base, const ObstacleOptions& o);
/** Writes the window into a costmap: what is known in the window replaces what was there, the rest
 * stays, and what lies outside of the costmap is left out. Throws std::invalid_argument for another
 * resolution. */
void update_costmap(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o, Costmap& costmap);
/** Makes what is in doubt passable, also where the window has left: for a robot that finds no path
 * without, to go and look. */
void admit_doubtful(Costmap& costmap);

}  // namespace talus::nav
