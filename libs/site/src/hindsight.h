#pragma once
#include "seen_rays.h"
#include "surroundings.h"

#include <talus/elevation_mapper.h>
#include <talus/site/site.h>
#include <talus/site/site_mapper.h>
#include <talus/site/traffic_map.h>
#include <talus/parameters.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace talus::site
{
/** Which scans hit what was cleared, in the tiles near the robot, by the index in a tile. */
using Trails = std::map<TileKey, std::map<int, HitScans>>;

/** Clears what moved from a tile. Of the scans around a cell, some hit what stands there, and
 * others have rays that passed through the same heights without a hit, before and after, inside of
 * the window and beyond it. Where so much more passed than was hit, in a square around the cell, it
 * was traffic; and what stands beside that and was hit by the same scans alone, or those next to
 * them, is of the same thing. `traffic`, unless it is null: counts where things moved, whether
 * anything of them is left or not. Returns the tiles beside it into which what has moved goes on.
 */
std::set<TileKey> clear_traffic(
    Site& site, const Parameters& parameters, const TileKey& key, const Scans& scans,
    Trails& trails, Traffic* traffic);

/** Judges cells of a tile that have changed, and those around them whose judgement rests on them:
 * they get the fills and the traversability of a map that has measured what the site has.
 * `changed`: indices in the tile. */
void reassess(
    Site& site, const Parameters& parameters, const TileKey& key, const std::vector<int>& changed);

/** Leaves guesses of a tile unjudged that no scan around it proves. A guess goes on level from the
 * ground on one side, and rays that passed over it may end far below it, often beyond the window.
 * So a ray has to end there, or close behind, at its height, and none lower. */
void forget_guesses(Site& site, const TileKey& key, const Scans& scans);

/** Corrects a site by later scans and those from farther away: the map of a drive is not
 * in a hurry. A tile is looked at when the robot is far away from it. */
class Hindsight
{
 public:
  /** Keeps the rays of a frame, unless the same sensor has just seen the same from the same place.
   */
  void add(const Frame& frame, int floor);
  /** Cells of a tile were kept: it has to be looked at again. */
  void touch(const TileKey& key) { touched_.insert(key); }
  /** Looks at one tile that the robot has left behind, packs those that were looked at, and forgets
   * scans that nothing needs. */
  void follow(Site& site, const ElevationMapper& map, const SiteMapper::Position& base);
  /** Counts from now on where things move. */
  void note_traffic() { traffic_.emplace(); }
  /** Null without note_traffic(). */
  const Traffic* traffic() const { return traffic_ ? &*traffic_ : nullptr; }
  /** Looks at all tiles that are left. */
  void finish(Site& site, const ElevationMapper& map);

 private:
  struct Seen
  {
    double stamp_s, x_m, y_m;
  };
  template <class Condition>
  void keep_if(const Condition& is_needed);
  void look_at(Site& site, const Parameters& parameters, const TileKey& key);
  void settle(const TileKey& key);
  bool is_settled(const TileKey& key) const;
  template <class Condition>
  void pack_settled(Site& site, const Condition& is_far);

  std::vector<SeenRays> scans_, spare_;  //!< in the order of time; memory that is not in use
  std::size_t taken_ = 0;  //!< scans
  std::map<std::uint32_t, Seen> newest_;  //!< of each sensor
  std::set<TileKey> touched_;
  std::set<TileKey> settled_;  //!< that may be packed, if all around them has been looked at
  Trails trails_;
  std::optional<Traffic> traffic_;
};

}  // namespace talus::site
