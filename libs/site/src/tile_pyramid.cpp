#include "tile_pyramid.h"

#include "kept_cell.h"

#include <algorithm>
#include <cmath>

namespace talus::site
{
namespace
{
constexpr std::size_t kOverviewBytes = std::size_t{64} << 20;

constexpr int kHalf = kTileCells / 2;

double standing_m(const SiteCell& c)
{
  const double height_m = c.cell.elevation_m - c.cell.ground_m;
  return height_m > 0 ? height_m : 0;  // nor NaN
}

/** Whether a known cell drives worse: an unjudged one is better than any. */
bool is_worse(const SiteCell& a, const SiteCell& b)
{
  const auto score = [](const SiteCell& c)
  { return std::isnan(c.cell.traversability) ? 2.0F : c.cell.traversability; };
  if (a.known() != b.known()) return a.known();
  if (score(a) != score(b)) return score(a) < score(b);
  return standing_m(a) > standing_m(b);
}

/** Where the worst of four cells is: who looks from far away must not miss a post. */
std::size_t worst_of(const SiteCell* cells, std::size_t upper, std::size_t lower)
{
  std::size_t worst = lower + 1;
  for (const std::size_t at : {lower, upper + 1, upper})
    if (is_worse(cells[at], cells[worst])) worst = at;
  return worst;
}

/** It, with the tallest of what stands on the four, and the state that is the most guessed. */
SiteCell joined(const SiteCell* cells, std::size_t upper, std::size_t lower, std::size_t worst)
{
  SiteCell all = cells[worst];
  for (const std::size_t at : {lower + 1, lower, upper + 1, upper})
  {
    const SiteCell& c = cells[at];
    if (!c.known()) continue;
    if (standing_m(c) > standing_m(all))
    {
      all.cell.elevation_m = all.cell.ground_m + static_cast<float>(standing_m(c));
      all.cell.elevation_variance_m2 = c.cell.elevation_variance_m2;
    }
    if (guessed_ground(c.cell) > guessed_ground(all.cell)) all.cell.state = c.cell.state;
  }
  return all;
}
}  // namespace

TilePyramid::TilePyramid(Site& site, int floor, int largest_cells, const std::string& folder)
    : tiles_(site.tiles),
      values_(site.channel_tiles),
      overviews_(kOverviewBytes, folder),
      overview_values_(kOverviewBytes, folder),
      floor_(floor)
{
  take_known_tiles();
  while (!empty() && std::max(width_cells(levels() - 1), height_cells(levels() - 1)) >
                         std::int64_t{largest_cells})
    add_level();
}

void TilePyramid::take_known_tiles()
{
  std::vector<TileKey> known;
  for (const TileKey& key : tiles_.keys())
  {
    if (key.floor != floor_) continue;
    const Tile* tile = tiles_.find(key);
    bool any = false;
    for (const SiteCell& c : tile->cells)
      if (c.known())
      {
        any = true;
        newest_s_ = std::max(newest_s_, c.seen_s);
      }
    if (any) known.push_back(key);
  }
  if (known.empty()) return;
  const auto [west, east] = std::minmax_element(
      known.begin(), known.end(), [](const TileKey& a, const TileKey& b) { return a.x < b.x; });
  const TileKey &south = known.front(), &north = known.back();
  min_tile_x_ = west->x;
  max_tile_y_ = north.y;
  min_cell_x_ = std::int64_t{west->x} * kTileCells;
  min_cell_y_ = std::int64_t{south.y} * kTileCells;
  width_cells_ = (std::int64_t{east->x} - west->x + 1) * kTileCells;
  height_cells_ = (std::int64_t{north.y} - south.y + 1) * kTileCells;
  auto& tiles = levels_.emplace_back();
  tiles.reserve(known.size());
  for (const TileKey& key : known) tiles.push_back({max_tile_y_ - key.y, key.x - min_tile_x_});
  std::sort(tiles.begin(), tiles.end());
}

void TilePyramid::add_level()
{
  const int from = levels() - 1, to = levels();
  std::vector<TileIndex> made;
  made.reserve(levels_[from].size());
  for (const TileIndex& p : levels_[from])
  {
    add_to_level(to, p);
    made.push_back({p.y / 2, p.x / 2});
  }
  std::sort(made.begin(), made.end());
  made.erase(std::unique(made.begin(), made.end()), made.end());
  levels_.push_back(std::move(made));
}

/** A tile of the level below becomes a quarter of one. A tile is valid until the next is asked for.
 */
void TilePyramid::add_to_level(int level, const TileIndex& below)
{
  std::vector<std::size_t> taken(kHalf * kHalf);
  std::vector<SiteCell> quarter(taken.size());
  const SiteCell* cells = tile(level - 1, below.x, below.y)->cells.data();
  const auto first_of = [&](int row)
  { return static_cast<std::size_t>(row_of(level - 1, row)) * kTileCells; };
  for (int r = 0; r < kHalf; ++r)
    for (int c = 0; c < kHalf; ++c)
    {
      const auto x = static_cast<std::size_t>(2 * c);
      const std::size_t upper = first_of(2 * r) + x, lower = first_of(2 * r + 1) + x;
      const std::size_t worst = worst_of(cells, upper, lower);
      taken[static_cast<std::size_t>(r * kHalf + c)] = worst;
      quarter[static_cast<std::size_t>(r * kHalf + c)] = joined(cells, upper, lower, worst);
    }
  const TileKey key{level, below.x / 2, below.y / 2};
  const int corner = (below.y % 2 * kTileCells + below.x % 2) * kHalf;
  const auto put = [&](auto& to, const auto& of)
  {
    for (int i = 0; i < kHalf * kHalf; ++i)
      to.cells[static_cast<std::size_t>(corner + i / kHalf * kTileCells + i % kHalf)] =
          of(static_cast<std::size_t>(i));
  };
  put(overviews_.at(key), [&](std::size_t i) { return quarter[i]; });
  const ChannelTile* const all = values(level - 1, below.x, below.y);
  if (!all) return;
  std::vector<ChannelRecord> quarter_values(taken.size());
  for (std::size_t i = 0; i < taken.size(); ++i) quarter_values[i] = all->cells[taken[i]];
  put(overview_values_.at(key), [&](std::size_t i) { return quarter_values[i]; });
}

const Tile* TilePyramid::tile(int level, int x, int y)
{
  if (!coverage(level, x, y, x, y).any) return nullptr;
  if (level > 0) return overviews_.find({level, x, y});
  return tiles_.find({floor_, x + min_tile_x_, max_tile_y_ - y});
}

const ChannelTile* TilePyramid::values(int level, int x, int y)
{
  if (level > 0) return overview_values_.find({level, x, y});
  return values_.find({floor_, x + min_tile_x_, max_tile_y_ - y});
}

void TilePyramid::for_each_tile(
    const std::function<void(const TileKey&, const Tile&, const ChannelTile*)>& f)
{
  for (const TileIndex& p : levels_.front())
    f({floor_, p.x + min_tile_x_, max_tile_y_ - p.y}, *tile(0, p.x, p.y), values(0, p.x, p.y));
}

TilePyramid::Coverage TilePyramid::coverage(int level, int x0, int y0, int x1, int y1) const
{
  const auto& tiles = levels_[level];
  Coverage c{false, true};
  for (TileIndex at{y0, x0}; at.y <= y1;)
  {
    const auto found = std::lower_bound(tiles.begin(), tiles.end(), at);
    if (found == tiles.end() || found->y > y1) return {c.any, false};
    if (found->y > at.y)
    {
      c.all = false;
      at = {found->y, x0};
      continue;
    }
    const auto behind = std::lower_bound(found, tiles.end(), TileIndex{at.y, x1 + 1});
    c.any |= behind != found;
    c.all &= behind - found == x1 - x0 + 1;
    if (c.any && !c.all) break;
    at = {at.y + 1, x0};
  }
  return c;
}

}  // namespace talus::site
