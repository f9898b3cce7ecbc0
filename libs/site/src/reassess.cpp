#include "hindsight.h"

#include "kept_cell.h"
#include "strips.h"
#include "kernels/cell.h"
#include "kernels/rule_constants.h"

#include <talus/elevation_mapper.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace talus::site
{
namespace
{
int cells_of(double length_m, const Parameters& p)
{
  return static_cast<int>(std::lround(length_m / p.resolution_m));
}

/** The parameters of a map of some cells that nobody drives through: no fill is near the robot. */
Parameters of_window(Parameters p, int cells)
{
  p.window_m = cells * p.resolution_m;
  p.sparsity_range_m = 0;
  return p;
}

/** A frame without points, of a sensor at the height of the ground above the middle of some cells.
 */
Frame empty_frame(
    const CellRect& cells, double resolution_m, const std::vector<CellRecord>& records)
{
  const auto middle_m = [&](std::int64_t first, int size)
  { return middle_of_cell_m(first + size / 2, resolution_m); };
  double sum_m = 0;
  int known = 0;
  for (const CellRecord& c : records)
    if (is_known(c)) sum_m += c.ground_m, ++known;
  Frame frame;
  frame.T_map_sensor.m[3] = middle_m(cells.min_cell_x, cells.width_cells);
  frame.T_map_sensor.m[7] = middle_m(cells.min_cell_y, cells.height_cells);
  frame.T_map_sensor.m[11] = known > 0 ? sum_m / known : 0;
  return frame;
}

/** The square around the cells of a tile that have changed, and a margin on each side. */
CellRect square_around(const TileKey& key, const std::vector<int>& changed, int margin)
{
  int min_x = kTileCells, max_x = 0, min_y = kTileCells, max_y = 0;
  for (const int at : changed)
  {
    min_x = std::min(min_x, at % kTileCells), max_x = std::max(max_x, at % kTileCells);
    min_y = std::min(min_y, at / kTileCells), max_y = std::max(max_y, at / kTileCells);
  }
  const int side = (std::max(max_x - min_x, max_y - min_y) / 2 + 1 + margin) * 2;
  return {
      std::int64_t{key.x} * kTileCells + min_x - margin,
      std::int64_t{key.y} * kTileCells + min_y - margin, side, side};
}

/** Whether the judgement of each cell of a square rests on one that has changed. */
std::vector<bool> affected(
    const TileKey& key, const std::vector<int>& changed, const CellRect& cells, int reach)
{
  std::vector<bool> are(cells.size());
  const auto first_x = static_cast<int>(std::int64_t{key.x} * kTileCells - cells.min_cell_x);
  const auto first_y = static_cast<int>(std::int64_t{key.y} * kTileCells - cells.min_cell_y);
  for (const int at : changed)
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx)
      {
        const int x = first_x + at % kTileCells + dx, y = first_y + at / kTileCells + dy;
        are[static_cast<std::size_t>(y * cells.width_cells + x)] = true;
      }
  return are;
}

/** The maximum of scans that are asked for each guess, from all that were around it. */
constexpr std::size_t kMaxAsked = 64;
/** A ray that ends close behind a guess, near its height, proves it. A ditch
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

void reassess(
    Site& site, const Parameters& parameters, const TileKey& key, const std::vector<int>& changed)
{
  const int reach = cells_of(parameters.feature_radius_m, parameters) + 1;
  const int margin = std::max(reach, cells_of(parameters.fill_search_m, parameters));
  const CellRect cells = square_around(key, changed, margin);
  std::vector<CellRecord> records(cells.size());
  for_each_kept_cell(
      site.tiles, cells, key.floor, [&](std::size_t i, const CellRecord& c) { records[i] = c; });
  constexpr int kOneThread = 1;  // of a few cells; more would cost more than they win
  ElevationMapper map(of_window(parameters, cells.width_cells), Backend::Cpu, kOneThread);
  const Frame frame = empty_frame(cells, parameters.resolution_m, records);
  map.update(frame);
  map.write_cells({cells}, records.data(), records.size());
  map.update(frame);
  const CellRecords judged = map.read_cells({cells});
  const std::vector<bool> wanted = affected(key, changed, cells, reach);
  const auto put = [&](const TilePart& part)
  {
    if (!site.tiles.has(part.key)) return;
    Tile& tile = site.tiles.at(part.key);
    for_each_cell(
        cells, part,
        [&](std::size_t i, std::size_t at)
        {
          CellRecord& kept = tile.cells[at].cell;
          if (!wanted[i] || !is_known(kept) || !is_known(judged[i])) return;
          kept = kept_of(judged[i]);
        });
  };
  for_each_tile(cells, key.floor, put);
}

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
