#include "judge_anew.h"

#include "kept_cell.h"

#include "kernels/cell.h"
#include "kernels/rule_constants.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace talus::site
{
namespace
{
/** So many scans at most are asked for each guess, from all that were around it. */
constexpr std::size_t kMaxAsked = 64;
/** A ray that ends at most so far behind a guess, within so much of its height, proves it. A ditch
 * is wider, and its far wall is hit lower. */
constexpr float kProvenBehind_m = 0.5F, kProvenWithin_m = 0.05F;

/** Ground that rays pass so far below does not go on. */
constexpr float kBelow_m = 0.1F;

/** Ground that rays have to prove: what goes on from one side, and what was presumed, but for where
 * the robot was. */
bool is_guess(const CellRecord& c)
{
  const bool was_driven = (c.evidence[0] & kernels::kRobotWasThere) != 0;
  const CellState state = state_of(c);
  return (state == CellState::FilledOneSided || (state == CellState::Presumed && !was_driven)) &&
         c.traversability > 0;
}

/** What the scans around it saw of a guess. */
class Proof
{
 public:
  explicit Proof(float ground_m) : ground_m_(ground_m) {}

  void add(const SeenRays::Passing& ray)
  {
    const bool far = ray.behind_m > kProvenBehind_m;
    const float above_m = ray.end_height_m - ground_m_;
    const float lowest_m = far ? ray.height_m : std::min(ray.height_m, ray.end_height_m);
    const float gentle_m = kBelow_m + kernels::kGentle * ray.behind_m;
    if (lowest_m < ground_m_ - kBelow_m)
      ++lower_;
    else if (far)
      ++(above_m < -gentle_m ? far_lower_ : far_level_);
    else
      level_ += std::abs(above_m) <= kProvenWithin_m;
  }
  /** Whether the ground was hit there or close behind, never lower, and farther behind not lower
   * than gentle ground would be in most scans. */
  bool holds() const { return level_ > 0 && lower_ == 0 && far_lower_ <= level_ + far_level_; }

 private:
  float ground_m_;
  int level_ = 0, lower_ = 0, far_level_ = 0, far_lower_ = 0;
};

bool is_proven(const Scans& scans, float resolution_m, double x_m, double y_m, float ground_m)
{
  Proof proof(ground_m);
  for (std::size_t i = 0; i < scans.size(); i += scans.size() / kMaxAsked + 1)
    if (const auto ray = scans[i]->lowest_behind(x_m, y_m, -resolution_m)) proof.add(*ray);
  return proof.holds();
}
}  // namespace

void forget_guesses(Site& site, const TileKey& key, const Scans& scans)
{
  const Tile* const tile = site.tiles.find(key);
  std::vector<std::size_t> unproven;
  for (std::size_t i = 0; tile && i < tile->cells.size(); ++i)
  {
    const CellRecord& c = tile->cells[i].cell;
    if (!is_guess(c)) continue;
    const auto at = static_cast<std::int64_t>(i);
    const double x_m = middle_of_cell_m(cell_of_tile(key.x, at % kTileCells), site.resolution_m);
    const double y_m = middle_of_cell_m(cell_of_tile(key.y, at / kTileCells), site.resolution_m);
    if (!is_proven(scans, static_cast<float>(site.resolution_m), x_m, y_m, c.ground_m))
      unproven.push_back(i);
  }
  if (unproven.empty()) return;
  Tile& changed = site.tiles.at(key);
  for (const std::size_t i : unproven) changed.cells[i].cell.traversability = NAN;
}

}  // namespace talus::site
