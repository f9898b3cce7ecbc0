#include "known_cells.h"
#include "changes.h"

#include <array>
#include <cmath>
#include <memory>
#include <set>

namespace talus::site
{
namespace
{
float top_m(const SiteCell& s)
{
  if (!has_seen(s)) return NAN;
  return has_elevation(s) ? s.cell.elevation_m : s.cell.ground_m;
}

/** The tops of a tile with one cell around it; NaN where none was seen. */
class Tops
{
 public:
  static constexpr int kSide = kTileCells + 2;

  /** Throws as TileStore. */
  void read(Site& site, const TileKey& key)
  {
    m_.fill(NAN);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (const Tile* tile = site.tiles.find({key.floor, key.x + dx, key.y + dy}))
          copy(*tile, dx * kTileCells, dy * kTileCells);
  }

  /** Whether a cell or one of its neighbours has a top within a step of a height. */
  bool has_near(int x, int y, float height_m, double step_m) const
  {
    for (int ny = y - 1; ny <= y + 1; ++ny)
      for (int nx = x - 1; nx <= x + 1; ++nx)
        if (std::abs(at(nx, ny) - height_m) <= step_m) return true;
    return false;
  }
  float at(int x, int y) const
  {
    return m_[static_cast<std::size_t>(y + 1) * kSide + static_cast<std::size_t>(x + 1)];
  }

 private:
  /** Those cells of a tile, which begins at (x0, y0), that are in reach. */
  void copy(const Tile& tile, int x0, int y0)
  {
    const int left = std::max(-1, x0), right = std::min(kTileCells, x0 + kTileCells - 1);
    const int low = std::max(-1, y0), high = std::min(kTileCells, y0 + kTileCells - 1);
    for (int y = low; y <= high; ++y)
      for (int x = left; x <= right; ++x)
        m_[static_cast<std::size_t>(y + 1) * kSide + static_cast<std::size_t>(x + 1)] =
            top_m(tile.cells[static_cast<std::size_t>((y - y0) * kTileCells + (x - x0))]);
  }

  std::array<float, static_cast<std::size_t>(kSide) * kSide> m_;
};

/** Whether what was there is still beside, or what is there was beside before. */
bool is_moved_edge(
    const CellChange& c, const Tops& from, const Tops& to, int x, int y, double step_m)
{
  return c.kind == Change::Gone ? to.has_near(x, y, from.at(x, y), step_m)
                                : from.has_near(x, y, to.at(x, y), step_m);
}
}  // namespace

CellChange change_of(const SiteCell& from, const SiteCell& to, double step_m)
{
  CellChange c;
  c.change_m = top_m(to) - top_m(from);
  if (!(std::abs(c.change_m) > step_m)) return c;
  const float ground_m = to.cell.ground_m - from.cell.ground_m;
  const bool is_ground = is_measured(from) && is_measured(to) && std::abs(ground_m) > step_m;
  if (is_ground || (!has_elevation(from) && !has_elevation(to)))
    c.kind = ground_m > 0 ? Change::Built : Change::Dug;
  else
    c.kind = c.change_m > 0 ? Change::Appeared : Change::Gone;
  return c;
}

void for_each_compared_tile(Site& from, Site& to, int floor, double step_m, const OnTile& f)
{
  const auto keys = to.tiles.keys();
  const std::set<TileKey> in_both(keys.begin(), keys.end());
  const auto before = std::make_unique<Tile>(), after = std::make_unique<Tile>();
  const auto tops_before = std::make_unique<Tops>(), tops_after = std::make_unique<Tops>();
  std::vector<CellChange> changes(before->cells.size());
  for (const TileKey& key : from.tiles.keys())
  {
    if (key.floor != floor || in_both.count(key) == 0) continue;
    *before = *from.tiles.find(key);
    *after = *to.tiles.find(key);
    tops_before->read(from, key);
    tops_after->read(to, key);
    for (int i = 0; i < kTileCells * kTileCells; ++i)
    {
      const auto cell = static_cast<std::size_t>(i);
      CellChange& c = changes[cell] = change_of(before->cells[cell], after->cells[cell], step_m);
      if (c.kind != Change::None &&
          is_moved_edge(c, *tops_before, *tops_after, i % kTileCells, i / kTileCells, step_m))
        c.kind = Change::None;
    }
    f(key, changes);
  }
}

}  // namespace talus::site
