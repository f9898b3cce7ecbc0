#include "falls.h"

#include "kernels/rule_constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace talus::nav
{
namespace
{
using kernels::kExplainedSlope, kernels::kExplained_steps, kernels::kGentle,
    kernels::kDitchDepthFactor;

constexpr double kReach_m = 4;  // to each side: the far side of what a level scanner overlooks
constexpr double kExplainedAnyway_steps = 0.5;  // of short lines, at the foot of a slope
constexpr int kBehind_cells = 3;  // in which a face rises

/** Around a cell, each with its opposite four places behind. */
constexpr std::array<Direction, 8> kDirections{
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
}  // namespace

Falls::Falls(const MapView& map, std::function<bool(int, int)> in_doubt)
    : view_(map),
      in_doubt_(std::move(in_doubt)),
      max_slope_(std::tan(map.parameters().slope_threshold_rad)),
      step_m_(map.parameters().step_threshold_m),
      verdicts_(view_.state.size(), Verdict::NotAsked)
{
}

bool Falls::is_slope(int ix, int iy) const
{
  if (verdicts_[view_.index(ix, iy)] == Verdict::NotAsked) judge_patch(ix, iy);
  return verdicts_[view_.index(ix, iy)] == Verdict::Slope;
}

/** Nobody knows how far it falls from the highest ground around where two of the three lines on its
 * other side meet nothing. */
bool Falls::is_open(const Ends& ends) const
{
  double highest_m = -HUGE_VAL;
  for (const auto& end : ends)
    if (end && !end->face_top_m) highest_m = std::max(highest_m, end->ground_m);
  for (std::size_t i = 0; i < ends.size(); i++)
  {
    if (!ends[i] || ends[i]->face_top_m || ends[i]->ground_m < highest_m - step_m_) continue;
    int met = 0;
    for (const std::size_t to : {3, 4, 5}) met += ends[(i + to) % ends.size()].has_value();
    if (met < 2) return true;
  }
  return false;
}

Falls::Fall Falls::fall_at(int ix, int iy) const
{
  Ends ends;
  for (std::size_t i = 0; i < ends.size(); i++) ends[i] = end_of(ix, iy, kDirections[i]);
  Fall all{false, is_open(ends)};
  for (std::size_t i = 0; i < ends.size() / 2; i++)
  {
    const auto &a = ends[i], &b = ends[i + ends.size() / 2];
    if (!a || !b) continue;
    const Fall f = b->ground_m <= a->ground_m ? fall(*a, *b) : fall(*b, *a);
    all.as_slope = all.as_slope || f.as_slope;
    all.farther = all.farther || f.farther;
  }
  return all;
}

/** Judges all cells in doubt that hang together with this one: at the foot of a ramp some of them
 * lie between level ground only. */
void Falls::judge_patch(int ix, int iy) const
{
  std::vector<std::pair<int, int>> patch{{ix, iy}};
  const int last = view_.window.cells - 1;
  bool falls = false;
  verdicts_[view_.index(ix, iy)] = Verdict::Slope;
  for (std::size_t i = 0; i < patch.size(); i++)
  {
    const auto [x, y] = patch[i];
    const Fall f = fall_at(x, y);
    if (f.farther) verdicts_[view_.index(x, y)] = Verdict::Drop;
    falls = falls || f.as_slope;
    for (int to_y = std::max(0, y - 1); to_y <= std::min(last, y + 1); to_y++)
      for (int to_x = std::max(0, x - 1); to_x <= std::min(last, x + 1); to_x++)
      {
        Verdict& verdict = verdicts_[view_.index(to_x, to_y)];
        if (verdict != Verdict::NotAsked || !in_doubt_(to_x, to_y)) continue;
        verdict = Verdict::Slope;
        patch.emplace_back(to_x, to_y);
      }
  }
  if (falls) return;
  for (const auto& [x, y] : patch) verdicts_[view_.index(x, y)] = Verdict::Drop;
}

bool Falls::is_measured(std::size_t cell) const
{
  const float state = view_.state[cell];
  return state == static_cast<float>(CellState::Measured) ||
         state == static_cast<float>(CellState::Presumed);
}

/** The first measured cell in a direction. */
std::optional<Falls::End> Falls::end_of(int ix, int iy, const Direction& to) const
{
  const double side_m = view_.window.resolution_m * std::hypot(to.dx, to.dy);
  const int n = view_.window.cells;
  for (int i = 1; i * side_m <= kReach_m; i++)
  {
    const int x = ix + i * to.dx, y = iy + i * to.dy;
    if (x < 0 || y < 0 || x >= n || y >= n) break;
    const std::size_t cell = view_.index(x, y);
    if (is_measured(cell)) return End{i * side_m, view_.ground[cell], face_top_m(x, y, to)};
  }
  return std::nullopt;
}

/** Of what stands there, or of measured ground that rises behind more steeply than a robot can
 * drive.
 */
std::optional<double> Falls::face_top_m(int ix, int iy, const Direction& to) const
{
  const double foot_m = view_.ground[view_.index(ix, iy)];
  const int n = view_.window.cells;
  std::optional<double> top_m;
  for (int i = 0; i <= kBehind_cells; i++)
  {
    const int x = ix + i * to.dx, y = iy + i * to.dy;
    if (x < 0 || y < 0 || x >= n || y >= n) break;
    const std::size_t cell = view_.index(x, y);
    const double length_m = i * view_.window.resolution_m * std::hypot(to.dx, to.dy);
    const double here_m = view_.top(cell);
    if (is_measured(cell) && here_m - foot_m > max_slope_ * length_m + kObject_m)
      top_m = std::max(here_m, top_m.value_or(here_m));
  }
  return top_m;
}

Falls::Fall Falls::fall(const End& high, const End& low) const
{
  const double length_m = high.distance_m + low.distance_m;
  const double fall_m = high.ground_m - low.ground_m;
  if (high.face_top_m) return {};  // its foot may be lower
  if (low.face_top_m > high.ground_m + step_m_) return {};  // a wall on the floor, not of a ditch
  if (low.face_top_m) return {false, kDitchDepthFactor * (fall_m - kGentle * length_m) > step_m_};
  const double explained_m = std::min(
      kExplainedSlope * max_slope_ * length_m + kExplainedAnyway_steps * step_m_,
      kExplained_steps * step_m_);
  return {fall_m > kGentle * length_m, fall_m > explained_m};
}

}  // namespace talus::nav
