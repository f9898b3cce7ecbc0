#include "guesses.h"

#include "kept_cell.h"

#include "kernels/rule_constants.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace talus::site
{
namespace
{
/** So many scans at most are asked for each guess, from all that were around it. */
constexpr std::size_t kMostAsked = 32;
/** So many of them contradict a guess alone if their rays passed below it: one may be a reflection.
 */
constexpr int kFewestBelow = 2;

bool is_guess(const CellRecord& c)
{
  const CellState state = state_of(c);
  return (state == CellState::FilledOneSided || state == CellState::Presumed) &&
         c.traversability > 0;
}

/** Whether rays of several scans passed below a guess, or more scans saw the ground behind it lower
 * than gentle ground than saw it there. */
bool is_contradicted(const Scans& scans, float resolution_m, double x_m, double y_m, float ground_m)
{
  int below = 0, lower = 0, level = 0;
  for (std::size_t i = 0; i < scans.size(); i += scans.size() / kMostAsked + 1)
  {
    const auto ray = scans[i]->lowest_behind(x_m, y_m, resolution_m);
    if (!ray) continue;
    const float gentle_m = kernels::kUndercutAhead_m + kernels::kGentle * ray->behind_m;
    below += ray->height_m < ground_m - kernels::kUndercutAhead_m;
    ++(ray->end_height_m < ground_m - gentle_m ? lower : level);
  }
  return below >= kFewestBelow || lower > level;
}
}  // namespace

void forget_guesses(Site& site, const TileKey& key, const Scans& scans)
{
  const Tile* const tile = site.tiles.find(key);
  std::vector<std::size_t> contradicted;
  for (std::size_t i = 0; tile && i < tile->cells.size(); ++i)
  {
    const CellRecord& c = tile->cells[i].cell;
    const auto middle_m = [&](std::int32_t of_tile, std::size_t place)
    { return (of_tile * kTileCells + static_cast<double>(place) + 0.5) * site.resolution_m; };
    if (is_guess(c) &&
        is_contradicted(
            scans, static_cast<float>(site.resolution_m), middle_m(key.x, i % kTileCells),
            middle_m(key.y, i / kTileCells), c.ground_m))
      contradicted.push_back(i);
  }
  if (contradicted.empty()) return;
  Tile& changed = site.tiles.at(key);
  for (const std::size_t i : contradicted) changed.cells[i].cell.traversability = NAN;
}

}  // namespace talus::site
