#include <talus/site/merge.h>

#include "known_cells.h"
#include "changes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace talus::site
{
namespace
{
constexpr float kSame_m = 0.03f;  //!< drives that are localized well differ by less
constexpr float kSigmas2 = 9;
constexpr float kStands_m = 0.15f;  //!< above its own ground: lower things hide in its noise
constexpr double kOffsetUnit_m = 1e-4;
constexpr double kFarthest_m = 1000;  //!< farther offsets are counted as that

// What two drives of one frame may differ by.
constexpr double kMaxOffset_m = 0.03, kMaxGround = 0.25, kMaxStanding = 0.15;
constexpr double kMinStanding_m2 = 0.1;  //!< less says nothing

/** Where the sites of two drives show nothing, bare or something. */
enum class Seen : std::uint8_t
{
  No,
  Bare,
  Stands
};

using SeenOfTile = std::array<Seen, std::tuple_size<decltype(Tile::cells)>::value>;

Seen seen_of(const SiteCell& s)
{
  if (!s.known() || !has_seen(s)) return Seen::No;
  return s.cell.elevation_m - s.cell.ground_m > kStands_m ? Seen::Stands : Seen::Bare;
}

void look_at(const Tile& tile, SeenOfTile& to)
{
  std::transform(tile.cells.begin(), tile.cells.end(), to.begin(), seen_of);
}

/** Whether something stands within a cell of one that is not at the edge of its tile. */
bool stands_near(const SeenOfTile& seen, std::size_t at)
{
  for (const std::size_t row : {at - kTileCells, at, at + kTileCells})
    for (std::size_t i = row - 1; i <= row + 1; ++i)
      if (seen[i] == Seen::Stands) return true;
  return false;
}

double share(std::size_t of, std::size_t all)
{
  return all > 0 ? static_cast<double>(of) / static_cast<double>(all) : 0;
}
}  // namespace

bool MapFit::fits() const
{
  const bool stands = standing_m2 < kMinStanding_m2 || standing_disagrees <= kMaxStanding;
  return !(std::abs(offset_z_m) > kMaxOffset_m) && ground_disagrees <= kMaxGround && stands;
}

void FitSums::add(const Tile& first, const Tile& second)
{
  for (std::size_t i = 0; i < first.cells.size(); ++i)
  {
    const SiteCell &a = first.cells[i], &b = second.cells[i];
    if (!a.known() || !b.known()) continue;
    ++both_;
    if (!is_measured(a) || !is_measured(b)) continue;
    const float d = b.cell.ground_m - a.cell.ground_m;
    const float noise_m2 = a.cell.ground_variance_m2 + b.cell.ground_variance_m2;
    ++ground_;
    ground_disagrees_ += std::abs(d) > kSame_m && d * d > kSigmas2 * noise_m2;
    ++offsets_[static_cast<int>(
        std::lround(std::clamp<double>(d, -kFarthest_m, kFarthest_m) / kOffsetUnit_m))];
  }
  add_standing(first, second);
}

/** Without the cells at the edge of the tile, whose neighbours lie in others. */
void FitSums::add_standing(const Tile& first, const Tile& second)
{
  SeenOfTile a, b;
  look_at(first, a);
  look_at(second, b);
  for (int y = 1; y + 1 < kTileCells; ++y)
    for (int x = 1; x + 1 < kTileCells; ++x)
    {
      const auto i = static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x);
      const bool in_a = a[i] == Seen::Stands, in_b = b[i] == Seen::Stands;
      if (a[i] == Seen::No || b[i] == Seen::No || (!in_a && !in_b)) continue;
      ++standing_;
      standing_disagrees_ += !(in_a ? stands_near(b, i) : stands_near(a, i));
    }
}

void FitSums::add(const FitSums& other)
{
  both_ += other.both_;
  ground_ += other.ground_;
  ground_disagrees_ += other.ground_disagrees_;
  standing_ += other.standing_;
  standing_disagrees_ += other.standing_disagrees_;
  for (const auto& [offset, count] : other.offsets_) offsets_[offset] += count;
}

double FitSums::median_m() const
{
  std::size_t below = 0;
  for (const auto& [offset, count] : offsets_)
    if (2 * (below += count) >= ground_) return offset * kOffsetUnit_m;
  return NAN;
}

MapFit FitSums::fit(double resolution_m) const
{
  const auto area_m2 = [&](std::size_t cells)
  { return static_cast<double>(cells) * resolution_m * resolution_m; };
  MapFit fit;
  fit.overlap_m2 = area_m2(both_);
  fit.ground_m2 = area_m2(ground_);
  fit.standing_m2 = area_m2(standing_);
  fit.offset_z_m = median_m();
  fit.ground_disagrees = share(ground_disagrees_, ground_);
  fit.standing_disagrees = share(standing_disagrees_, standing_);
  return fit;
}

MapFit fit_of(Site& first, Site& second, int floor)
{
  FitSums sums;
  const auto tile = std::make_unique<Tile>();
  for (const TileKey& key : first.tiles.keys())
  {
    if (key.floor != floor || !second.tiles.has(key)) continue;
    *tile = *first.tiles.find(key);
    sums.add(*tile, *second.tiles.find(key));
  }
  MapFit fit = sums.fit(first.resolution_m);
  fit.second = 1;
  return fit;
}

}  // namespace talus::site
