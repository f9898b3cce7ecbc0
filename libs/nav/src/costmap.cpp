#include <talus/nav/costmap.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "surface_view.h"

namespace talus::nav
{
namespace
{
constexpr float kQuantised = 0.02F;  // by costmaps that store probabilities as bytes, at most
constexpr double kMaxCells = 4e7, kMaxCell = 1e9;
constexpr double kRounding_cells = 1e-6;

bool is_about(float p, float wanted) { return std::abs(p - wanted) < kQuantised; }

bool may_drop(float p) { return is_about(p, kMayDrop) || is_about(p, kMayDropBesideWall); }

bool drops_from_nearby(float p)
{
  return is_about(p, kDropsFromNearby) || is_about(p, kDropsFromNearbyBesideWall);
}

float blocked(Passage cell, bool doubtful, bool edge)
{
  if (!doubtful) return edge ? kEdge : kObstacle;
  if (cell == Passage::Obstacle) return edge ? kDropsFromNearby : kDropsFromNearbyBesideWall;
  return edge ? kMayDrop : kMayDropBesideWall;
}
}  // namespace

std::vector<float> free_probabilities(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o)
{
  const auto [cells, doubtful] = judge_cells(map, T_map_base, o);
  const auto edges = find_edges(map, T_map_base, cells);
  const auto& traversability = map.layer(Layer::Traversability);
  std::vector<float> out(cells.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < cells.size(); i++)
  {
    if (cells[i] == Passage::Free)  // NaN below the robot
      out[i] = kJustFree + (traversability[i] > 0 ? 0.4F * traversability[i] : 0.0F);
    else if (cells[i] == Passage::Obstacle || doubtful[i])
      out[i] = blocked(cells[i], doubtful[i], edges[i]);
  }
  return out;
}

float updated(float before, float now)
{
  return std::isnan(now) || (may_drop(now) && drops_from_nearby(before)) ? before : now;
}

float admitted(float before) { return may_drop(before) ? kJustFree : before; }

void Costmap::cover(double min_x_m, double max_x_m, double min_y_m, double max_y_m)
{
  const auto cell = [this](double at_m)
  { return std::floor(at_m / resolution_m + kRounding_cells); };
  const bool none = free.empty();
  const auto first_x = static_cast<double>(min_cell_x), first_y = static_cast<double>(min_cell_y);
  const double x0 = none ? cell(min_x_m) : std::min(cell(min_x_m), first_x);
  const double y0 = none ? cell(min_y_m) : std::min(cell(min_y_m), first_y);
  const double x1 = none ? cell(max_x_m) : std::max(cell(max_x_m), first_x + columns);
  const double y1 = none ? cell(max_y_m) : std::max(cell(max_y_m), first_y + rows);
  if (!((x1 - x0) * (y1 - y0) <= kMaxCells && std::abs(x0) + std::abs(y0) < kMaxCell))
    throw std::invalid_argument(
        "a costmap cannot reach from (" + fixed_text(x0 * resolution_m, 1) + ", " +
        fixed_text(y0 * resolution_m, 1) + ") to (" + fixed_text(x1 * resolution_m, 1) + ", " +
        fixed_text(y1 * resolution_m, 1) + ") m: its limit is forty million cells");
  Costmap out{
      resolution_m,
      static_cast<std::int64_t>(x0),
      static_cast<std::int64_t>(y0),
      static_cast<int>(x1 - x0),
      static_cast<int>(y1 - y0),
      {}};
  if (!none && out.columns == columns && out.rows == rows) return;
  out.free.assign(out.index(0, out.rows), kHopeful);
  for (int y = 0; y < rows; y++)
    std::copy_n(
        free.begin() + static_cast<std::ptrdiff_t>(index(0, y)), columns,
        out.free.begin() +
            static_cast<std::ptrdiff_t>(
                out.index(static_cast<int>(first_x - x0), static_cast<int>(first_y - y0) + y)));
  *this = std::move(out);
}

Costmap costmap_from_map(const MapView& map, const Pose& T_map_base, const ObstacleOptions& o)
{
  const Window w = map.window();
  Costmap out{w.resolution_m, w.min_cell_x, w.min_cell_y, w.cells, w.cells, {}};
  out.free = free_probabilities(map, T_map_base, o);
  for (float& p : out.free) p = updated(kHopeful, p);
  return out;
}

void update_costmap(
    const MapView& map, const Pose& T_map_base, const ObstacleOptions& o, Costmap& costmap)
{
  const Window w = map.window();
  if (w.resolution_m != costmap.resolution_m)
    throw std::invalid_argument(
        "a costmap with cells of " + number_text(costmap.resolution_m, 6) +
        " m cannot hold a map with cells of " + number_text(w.resolution_m, 6) + " m");
  const auto now = free_probabilities(map, T_map_base, o);
  for (int iy = 0; iy < w.cells; iy++)
    for (int ix = 0; ix < w.cells; ix++)
    {
      const std::int64_t x = w.min_cell_x + ix - costmap.min_cell_x;
      const std::int64_t y = w.min_cell_y + iy - costmap.min_cell_y;
      if (x < 0 || y < 0 || x >= costmap.columns || y >= costmap.rows) continue;
      float& cell = costmap.free[costmap.index(static_cast<int>(x), static_cast<int>(y))];
      cell = updated(cell, now[static_cast<std::size_t>(iy * w.cells + ix)]);
    }
}

void admit_doubtful(Costmap& costmap)
{
  for (float& p : costmap.free) p = admitted(p);
}

}  // namespace talus::nav
