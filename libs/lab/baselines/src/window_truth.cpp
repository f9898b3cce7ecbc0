#include <talus/baselines/window_truth.h>

#include <algorithm>
#include <cmath>

#include "spread.h"

namespace talus::baselines
{
namespace
{
constexpr double kRobot_m = 0.35;
constexpr double kApart_m = 0.4;  //!< between sensor positions from which visibility is asked
constexpr std::size_t kPositions = 12;
constexpr double kHitTolerance_m = 0.03;

/** Frames from which to ask what could be seen: the last one, and earlier ones some way apart. */
std::vector<const ScanFrame*> viewpoints(const std::vector<ScanFrame>& frames, std::size_t now)
{
  std::vector<const ScanFrame*> chosen{&frames[now]};
  for (std::size_t i = now; i-- > 0 && chosen.size() < kPositions;)
  {
    const Pose &a = frames[i].T_true, &b = chosen.back()->T_true;
    if (std::hypot(a.x() - b.x(), a.y() - b.y()) >= kApart_m) chosen.push_back(&frames[i]);
  }
  return chosen;
}

Pose true_base(const ScanFrame& frame) { return pose_of_base(frame.T_true, frame.T_base_sensor); }

/** Whether a direction of the sensor frame is inside the field of view. */
bool in_view(const sim::Scanner& scanner, const sim::Vec3& d)
{
  const auto [low, high] =
      std::minmax_element(scanner.elevations_rad.begin(), scanner.elevations_rad.end());
  const double elevation = std::atan2(d.z, std::hypot(d.x, d.y));
  if (elevation < *low || elevation > *high) return false;
  return !scanner.camera || (d.x > 0 && std::abs(d.y) < scanner.half_width_tan * d.x);
}

bool sees(
    const ScanFrame& frame, const sim::Vec3& place, const Parameters& p, const sim::Scene& scene,
    const sim::Scanner& scanner)
{
  const Pose& from = frame.T_true;
  const sim::Vec3 origin{from.x(), from.y(), from.z()};
  const sim::Vec3 way = place - origin;
  const double distance = sim::norm(way);
  const sim::Vec3 in_sensor = sim::rotate_back(from, way);
  if (cell_index(window_around(p, true_base(frame)), place.x, place.y) < 0) return false;
  if (way.z < p.min_height_m || way.z > p.max_height_m) return false;
  if (!in_view(scanner, in_sensor)) return false;
  const auto hit = scene.cast({origin, sim::normalized(way)}, distance);
  return !hit || hit->range_m > distance - kHitTolerance_m;
}

void mark_visible(
    WindowTruth& here, const TruthMap& truth, const std::vector<const ScanFrame*>& from,
    const Parameters& p, const sim::Scene& scene, const sim::Scanner& scanner)
{
  const Window& w = here.window;
  for (int k = 0; k < w.cells * w.cells; ++k)
  {
    const auto i = static_cast<std::size_t>(k);
    if (here.could_see[i] || here.at[i] < 0 || !here.free_now[i]) continue;
    const auto [x_m, y_m] = middle_of_cell(w, i);
    const sim::Vec3 place{
        x_m, y_m, truth.truth.ground[static_cast<std::size_t>(here.at[i])] + 0.002};
    here.could_see[i] = std::any_of(
        from.begin(), from.end(),
        [&](const ScanFrame* frame) { return sees(*frame, place, p, scene, scanner); });
  }
}

void fill_cell(
    WindowTruth& here, std::size_t k, std::size_t at, const TruthMap& truth,
    const Observed& observed, const MoverTruth* movers)
{
  const bool mover = movers && movers->blocked_now[at];
  here.blocked_now[k] = truth.blocked(at) || mover;
  here.free_now[k] = truth.free(at) && !mover;
  here.touched[k] = movers && movers->touched[at];
  here.could_see[k] = observed.ground_hit[at];
}

}  // namespace

std::vector<std::uint8_t> flood(
    const std::vector<std::uint8_t>& open, const std::vector<std::uint8_t>& start, int cells)
{
  std::vector<std::uint8_t> reached(open.size(), 0);
  std::vector<int> todo;
  for (std::size_t i = 0; i < start.size(); ++i)
    if (start[i]) reached[i] = 1, todo.push_back(static_cast<int>(i));
  spread(todo, reached, cells, [&](std::size_t, std::size_t to) { return open[to] != 0; });
  return reached;
}

WindowTruth window_truth(
    const TruthMap& truth, const Observed& observed, const MoverTruth* movers,
    const std::vector<ScanFrame>& frames, std::size_t now, const Parameters& parameters,
    const sim::Scene* scene, const sim::Scanner* scanner)
{
  WindowTruth here;
  const Pose &T_true = frames[now].T_true, T_base = true_base(frames[now]);
  here.window =
      window_around(parameters, pose_of_base(frames[now].T_map_sensor, frames[now].T_base_sensor));
  here.highest_shown_m = T_true.z() + parameters.max_height_m;
  const int n = here.window.cells;
  const auto size = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  here.at.assign(size, -1);
  for (auto* layer :
       {&here.free_now, &here.blocked_now, &here.touched, &here.could_see, &here.start})
    layer->assign(size, 0);
  for (int k = 0; k < n * n; ++k)
  {
    const auto i = static_cast<std::size_t>(k);
    here.at[i] = truth.index(here.window.min_cell_x + k % n, here.window.min_cell_y + k / n);
    const double x = here.window.min_x_m() + (k % n + 0.5) * here.window.resolution_m;
    const double y =
        here.window.min_y_m() + (static_cast<double>(k / n) + 0.5) * here.window.resolution_m;
    here.start[i] = std::hypot(x - T_base.x(), y - T_base.y()) < kRobot_m;
    if (here.at[i] >= 0)
      fill_cell(here, i, static_cast<std::size_t>(here.at[i]), truth, observed, movers);
  }
  here.reachable = flood(here.free_now, here.start, n);
  if (scene && scanner)
    mark_visible(here, truth, viewpoints(frames, now), parameters, *scene, *scanner);
  std::vector<std::uint8_t> seen_free(size);
  for (std::size_t k = 0; k < size; ++k) seen_free[k] = here.free_now[k] && here.could_see[k];
  here.reachable_seen = flood(seen_free, here.start, n);
  return here;
}

}  // namespace talus::baselines
