#include "hindsight.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace talus::site
{
namespace
{
/// @name Which scans are kept: at a distance or time from the one before, and how many.
/// @{
constexpr double kEvery_m = 0.5, kEvery_s = 0.5;
constexpr std::size_t kMaxScans = 512;
/// @}
constexpr double kReach_m = 30;  //!< range of a scan that is used, along x and y

/** How far a place is from a tile, along x or y. */
double away_m(const TileKey& key, double resolution_m, double x_m, double y_m)
{
  const double tile_m = kTileCells * resolution_m;
  const auto beyond = [&](std::int32_t tile, double at_m) {
    return std::max({tile * tile_m - at_m, at_m - (tile + 1) * tile_m, 0.0});
  };
  return std::max(beyond(key.x, x_m), beyond(key.y, y_m));
}
}  // namespace

void Hindsight::add(const Frame& frame, int floor)
{
  const double x_m = frame.T_map_sensor.x(), y_m = frame.T_map_sensor.y();
  const auto [newest, is_first] = newest_.try_emplace(frame.sensor, Seen{frame.stamp_s, x_m, y_m});
  Seen& seen = newest->second;
  const bool moved = std::max(std::abs(x_m - seen.x_m), std::abs(y_m - seen.y_m)) >= kEvery_m;
  const bool waited = std::abs(frame.stamp_s - seen.stamp_s) >= kEvery_s;
  if (!is_first && !moved && !waited) return;
  seen = {frame.stamp_s, x_m, y_m};
  // The robot has been near here for long.
  if (scans_.size() >= kMaxScans)
    keep_if([](std::size_t i, const SeenRays&) { return i % 2 == 1; });
  if (spare_.empty()) spare_.emplace_back();
  scans_.push_back(std::move(spare_.back()));
  spare_.pop_back();
  scans_.back().take(frame, floor, taken_++);
}

/** Keeps the scans that a condition on their place in the list and themselves asks for. */
template <class Condition>
void Hindsight::keep_if(const Condition& is_needed)
{
  std::size_t kept = 0;
  for (std::size_t i = 0; i < scans_.size(); ++i)
    if (!is_needed(i, scans_[i]))
      spare_.push_back(std::move(scans_[i]));
    else if (kept++ != i)
      scans_[kept - 1] = std::move(scans_[i]);
  scans_.resize(kept);
}

void Hindsight::follow(Site& site, const ElevationMapper& map, const SiteMapper::Position& base)
{
  const double far_m = map.parameters().window_m / 2 + kReach_m;
  const auto is_far = [&](const TileKey& key)
  { return away_m(key, site.resolution_m, base.x_m, base.y_m) > far_m; };
  const auto first_far = [&] { return std::find_if(touched_.begin(), touched_.end(), is_far); };
  if (const auto tile = first_far(); tile != touched_.end())
  {
    const TileKey key = *tile;
    touched_.erase(tile);
    look_at(site, map.parameters(), key);
    settle(key);
  }
  if (first_far() == touched_.end()) pack_settled(site, is_far);
  const double needed_m = far_m + kReach_m + 2 * kTileCells * site.resolution_m;
  keep_if(
      [&](std::size_t, const SeenRays& s)
      { return std::max(std::abs(s.x_m() - base.x_m), std::abs(s.y_m() - base.y_m)) < needed_m; });
  for (auto trail = trails_.begin(); trail != trails_.end();)
  {
    const bool is_needed = away_m(trail->first, site.resolution_m, base.x_m, base.y_m) < needed_m;
    trail = is_needed ? std::next(trail) : trails_.erase(trail);
  }
}

void Hindsight::finish(Site& site, const ElevationMapper& map)
{
  site.tiles.unpack_all();
  while (!touched_.empty())
  {
    const TileKey key = *touched_.begin();
    touched_.erase(touched_.begin());
    look_at(site, map.parameters(), key);
  }
}

/** A tile was looked at, and those around it may have changed. */
void Hindsight::settle(const TileKey& key)
{
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) settled_.insert({key.floor, key.x + dx, key.y + dy});
}

/** Nothing will ask for it any more: where a tile around it is looked at later, it is settled
 * again.
 */
bool Hindsight::is_settled(const TileKey& key) const
{
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (touched_.count({key.floor, key.x + dx, key.y + dy}) > 0) return false;
  return true;
}

template <class Condition>
void Hindsight::pack_settled(Site& site, const Condition& is_far)
{
  for (const TileKey& key : settled_)
    if (is_settled(key) && is_far(key))
    {
      site.tiles.pack(key);
      site.channel_tiles.pack(key);
    }
  settled_.clear();
}

void Hindsight::look_at(Site& site, const Parameters& parameters, const TileKey& key)
{
  Scans around;
  for (const SeenRays& scan : scans_)
    if (scan.floor() == key.floor &&
        away_m(key, site.resolution_m, scan.x_m(), scan.y_m()) < kReach_m)
      around.push_back(&scan);
  touched_.merge(
      clear_traffic(site, parameters, key, around, trails_, traffic_ ? &*traffic_ : nullptr));
  forget_guesses(site, key, around);
}

}  // namespace talus::site
