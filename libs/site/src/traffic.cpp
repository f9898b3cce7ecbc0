#include "hindsight.h"

#include "known_cells.h"
#include "kept_cell.h"
#include "surroundings.h"

#include <talus/site/traffic_map.h>
#include <talus/io/geotiff.h>
#include <talus/site/islands.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <vector>

namespace talus::site
{
namespace
{
/// @name What is of the same thing as what has moved: so near, passed so often, and beside so much
/// of it
/// @{
constexpr double kBeside_m = 0.5;
constexpr int kPassesPerHitBeside = 1;
/** The share of what stands near, and stood there before, that has moved: a few cells of the front
 * of a parked car take nothing with them. */
constexpr double kMinMoved = 0.2;
/// @}

/** Goes on from what has moved to what is of the same thing. */
class SameThing
{
 public:
  SameThing(const Surroundings& around, const std::vector<Column>& columns, double resolution_m)
      : around_(around),
        radius_(static_cast<int>(std::lround(kBeside_m / resolution_m))),
        standing_(around.rect().size()),
        moved_(around.rect().size()),
        left_(around.rect().size()),
        beside_(around.rect().size())
  {
    for (const Column& c : columns)
      if (c.stands()) standing_[c.at] = &c;
  }
  /** Something was there in these scans that has moved, whatever is there now. */
  void begin(std::size_t at, const HitScans& when)
  {
    left_[at] = true;
    open_.push_back({at, with_next(when)});
  }
  /** What stands there has moved. */
  void take(const Column& c)
  {
    moved_[c.at] = true;
    begin(c.at, when(c));
  }
  void go_on()
  {
    while (!open_.empty())
    {
      const Open from = open_.back();
      open_.pop_back();
      around_.for_each_near(
          from.at, radius_,
          [&](std::size_t near)
          {
            if (!standing_[near] || moved_[near]) return;
            beside_[near] |= from.when;
            if (is_of(*standing_[near], beside_[near])) take(*standing_[near]);
          });
    }
  }
  bool has_moved(std::size_t at) const { return moved_[at]; }

 private:
  /** What only scans hit that were not kept was hit when what is beside it was. */
  HitScans when(const Column& c) const
  {
    HitScans all = c.when;
    if (all.none())
      around_.for_each_near(
          c.at, radius_,
          [&](std::size_t near)
          {
            if (standing_[near]) all |= standing_[near]->when;
          });
    return all;
  }
  static HitScans with_next(const HitScans& when)
  {
    const std::size_t last = when.size() - 1;
    return when | when << 1 | when >> last | when >> 1 | when << last;
  }
  bool is_of(const Column& c, const HitScans& beside) const
  {
    return (when(c) & ~beside).none() && is_beside_enough(c.at) &&
           around_.sums_around(c.at).passed(kPassesPerHitBeside);
  }
  bool is_beside_enough(std::size_t at) const
  {
    int left = 0, all = 0;
    around_.for_each_near(
        at, radius_,
        [&](std::size_t near)
        {
          left += left_[near];
          all += left_[near] || standing_[near];
        });
    return left >= kMinMoved * all;
  }

  struct Open
  {
    std::size_t at;
    HitScans when;
  };
  const Surroundings& around_;
  int radius_;
  std::vector<const Column*> standing_;
  std::vector<bool> moved_;
  std::vector<bool> left_;  //!< what was there has moved, now or before
  std::vector<HitScans> beside_;  //!< that hit what has moved near a cell
  std::vector<Open> open_;
};

void clear(SiteCell& s)
{
  const bool measured = is_measured(s);
  s.cell.elevation_m = measured ? s.cell.ground_m : NAN;
  s.cell.elevation_variance_m2 = measured ? s.cell.ground_variance_m2 : NAN;
}

/** Of a tile: what stands there and has moved. */
struct Moved
{
  std::vector<int> cells;  //!< indices in the tile, ascending
  std::set<TileKey> beyond;  //!< tiles into which it goes on
};

Moved moved_of(
    const TileKey& key, const std::vector<Column>& columns, Surroundings around,
    double resolution_m, Trails& trails)
{
  for (const Column& c : columns)
    if (c.stands()) around.put(c);
  SameThing thing(around, columns, resolution_m);
  for (const Column& c : columns)
    if (c.stands() && around.sums_around(c.at).moved()) thing.take(c);
  around.for_each_tile(
      [&](const TileKey& near)
      {
        const auto trail = trails.find(near);
        if (trail == trails.end()) return;
        for (const auto& [cell, when] : trail->second)
          if (const auto at = around.index_of(near, cell)) thing.begin(*at, when);
      });
  thing.go_on();
  Moved moved;
  for (const Column& c : columns)
  {
    if (!c.stands() || !thing.has_moved(c.at)) continue;
    const auto [tile, index] = around.in_tile(c.at);
    if (!(tile == key))
      moved.beyond.insert(tile);
    else
    {
      moved.cells.push_back(index);
      trails[key][index] |= c.when;
    }
  }
  return moved;
}

/** `moved`: of what stands, ascending. */
void note_traffic(
    const TileKey& key, const std::vector<Column>& columns, Surroundings around,
    const std::vector<int>& moved, TrafficTile& traffic)
{
  for (const Column& c : columns) around.put(c);
  for (const Column& c : columns)
  {
    const auto [tile, index] = around.in_tile(c.at);
    if (!(tile == key) || c.recent.scans == 0) continue;
    if (!std::binary_search(moved.begin(), moved.end(), index) && !around.sums_around(c.at).moved())
      continue;
    TrafficCell& cell = traffic.cells[index];
    cell.times += c.recent.times;
    cell.scans += c.recent.scans;
  }
}

/** Empty where nothing moved in these tiles. */
io::LayerStack layers_of(const Traffic& traffic, const std::vector<TileKey>& keys, double cell_m)
{
  std::vector<TileKey> moved;
  for (const TileKey& key : keys)
    if (const auto tile = traffic.find(key); tile != traffic.end() && !tile->second.cells.empty())
      moved.push_back(key);
  if (moved.empty()) return {};
  const auto [west, east] = std::minmax_element(
      moved.begin(), moved.end(), [](const TileKey& a, const TileKey& b) { return a.x < b.x; });
  const int min_x = west->x, min_y = moved.front().y;  // they ascend
  const int tiles_x = east->x - min_x + 1, tiles_y = moved.back().y - min_y + 1;
  io::LayerStack stack{
      tiles_x * kTileCells,        tiles_y * kTileCells, cell_m, min_x * kTileCells * cell_m,
      min_y * kTileCells * cell_m, {"times", "scans"},   {}};
  const auto width = static_cast<std::size_t>(stack.cells_x);
  stack.layers.assign(2, std::vector<float>(width * static_cast<std::size_t>(stack.cells_y), NAN));
  const auto put = [&](std::size_t layer, const TileKey& key, int index, float value)
  {
    const int x = (key.x - min_x) * kTileCells + index % kTileCells;
    const int y = (key.y - min_y) * kTileCells + index / kTileCells;
    stack.layers[layer][static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] = value;
  };
  for (const TileKey& key : moved)
    for (const auto& [index, cell] : traffic.at(key).cells)
    {
      put(0, key, index, static_cast<float>(cell.times));
      put(1, key, index, static_cast<float>(cell.scans));
    }
  return stack;
}

std::vector<TileKey> tiles_of(const Site& site, int floor)
{
  std::vector<TileKey> tiles;
  for (const TileKey& key : site.tiles.keys())
    if (key.floor == floor) tiles.push_back(key);
  return tiles;
}
}  // namespace

std::set<TileKey> clear_traffic(
    Site& site, const Parameters& parameters, const TileKey& key, const Scans& scans,
    Trails& trails, Traffic* traffic)
{
  if (scans.empty()) return {};
  const Surroundings around(key, site.resolution_m);
  TrafficTile* const noted = traffic ? &(*traffic)[key] : nullptr;
  const std::vector<Column> columns = count_columns(
      site, around.rect(), key.floor, noted ? Which::All : Which::Standing, scans,
      noted ? noted->until_s : HUGE_VAL);
  const Moved moved = moved_of(key, columns, around, site.resolution_m, trails);
  if (noted)
  {
    note_traffic(key, columns, around, moved.cells, *noted);
    noted->until_s = scans.back()->stamp_s();
  }
  if (moved.cells.empty()) return {};
  Tile& tile = site.tiles.at(key);
  for (const int at : moved.cells) clear(tile.cells[static_cast<std::size_t>(at)]);
  if (site.channel_tiles.has(key))
  {
    ChannelTile& values = site.channel_tiles.at(key);
    for (const int at : moved.cells) forget_standing(values.cells[static_cast<std::size_t>(at)]);
  }
  reassess(site, parameters, key, moved.cells);
  return moved.beyond;
}

void write_traffic_files(const std::string& path, const Traffic& traffic, Site& site, Far far)
{
  for (const int floor : floors_of(site))
  {
    auto islands = far == Far::Apart ? islands_of(site, floor) : std::vector<Island>();
    if (islands.empty()) islands.push_back({tiles_of(site, floor)});
    for (std::size_t i = 0; i < islands.size(); ++i)
    {
      const io::LayerStack stack = layers_of(traffic, islands[i].tiles, site.resolution_m);
      if (stack.layers.empty()) continue;
      io::write_geotiff(with_island(with_floor(path, floor), i), stack, {}, site.origin);
    }
  }
}

}  // namespace talus::site
