#include <talus/baselines/window_cells.h>
#include <talus/baselines/window_truth.h>

#include <algorithm>
#include <cmath>

namespace talus::baselines
{
namespace
{
constexpr double kRobot_m = 0.35;
constexpr double kApart_m = 0.4;  //!< between sensor positions from which visibility is asked
constexpr std::size_t kPositions = 12;
constexpr double kHitTolerance_m = 0.03;

/** Frames from which visibility is asked: the last one, and earlier ones some distance apart. */
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
    const ScanFrame& frame, const sim::Vec3& target_m, const Parameters& p, const sim::Scene& scene,
    const sim::Scanner& scanner)
{
  const Pose& from = frame.T_true;
  const sim::Vec3 origin{from.x(), from.y(), from.z()};
  const sim::Vec3 to_target_m = target_m - origin;
  const double distance = sim::norm(to_target_m);
  const sim::Vec3 in_sensor = sim::rotate_back(from, to_target_m);
  if (cell_index(window_around(p, true_base(frame)), target_m.x, target_m.y) < 0) return false;
  if (to_target_m.z < p.min_height_m || to_target_m.z > p.max_height_m) return false;
  if (!in_view(scanner, in_sensor)) return false;
  const auto hit = scene.cast({origin, sim::normalized(to_target_m)}, distance);
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
    const sim::Vec3 target_m{x_m, y_m, truth.truth.ground[here.at[i]] + 0.002};
    here.could_see[i] = std::any_of(
        from.begin(), from.end(),
        [&](const ScanFrame* frame) { return sees(*frame, target_m, p, scene, scanner); });
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

constexpr int kAround_cells = 3;
constexpr float kGroundHit_m = 0.05f;
constexpr float kTopTolerance_m = 0.06f;

/** Calls visit(index) for a cell and those up to `cells` from it. */
template <class Visit>
void for_each_around(const sim::TruthWindow& area, std::size_t at, int cells, const Visit& visit)
{
  const int ix = static_cast<int>(at) % area.cells_x, iy = static_cast<int>(at) / area.cells_x;
  for (int y = std::max(iy - cells, 0); y <= std::min(iy + cells, area.cells_y - 1); ++y)
    for (int x = std::max(ix - cells, 0); x <= std::min(ix + cells, area.cells_x - 1); ++x)
      visit(static_cast<std::size_t>(y * area.cells_x + x));
}

std::int64_t cell_of(double v_m, double resolution_m)
{
  return static_cast<std::int64_t>(std::floor(v_m / resolution_m));
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
    const auto [x_m, y_m] = middle_of_cell(here.window, i);
    here.start[i] = std::hypot(x_m - T_base.x(), y_m - T_base.y()) < kRobot_m;
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

Observed::Observed(const TruthMap& truth, const Parameters& parameters)
    : ground_hit(truth.size(), 0),
      high_hit_(truth.size(), 0),
      lowest_m_(truth.size(), NAN),
      highest_m_(truth.size(), NAN),
      ground_up_to_m_(truth.size(), NAN),
      truth_(truth),
      parameters_(parameters)
{
  for (std::size_t i = 0; i < truth.size(); ++i)
  {
    float& highest = ground_up_to_m_[i];
    for_each_around(
        truth.truth.window, i, 1,
        [&](std::size_t next) { highest = std::fmax(highest, truth.truth.ground[next]); });
    highest += kGroundHit_m;
  }
}

void Observed::forget_outside(const Window& window)
{
  for (std::size_t i = 0; i < truth_.size(); ++i)
  {
    const auto [x_m, y_m] = truth_.middle(i);
    if (cell_index(window, x_m, y_m) >= 0) continue;
    ground_hit[i] = high_hit_[i] = 0;
    lowest_m_[i] = highest_m_[i] = NAN;
  }
}

void Observed::add(const ScanFrame& frame)
{
  const Window w = window_around(parameters_, pose_of_base(frame.T_true, frame.T_base_sensor));
  const double res = truth_.truth.window.resolution_m;
  forget_outside(w);
  Frame view = frame.view();
  view.T_map_sensor = frame.T_true;
  for (const MapPoint& p : accepted_points(view, parameters_))
  {
    const int at = truth_.index(cell_of(p.x_m, res), cell_of(p.y_m, res));
    if (at < 0 || cell_index(w, p.x_m, p.y_m) < 0) continue;
    const auto i = static_cast<std::size_t>(at);
    const float above = p.z_m - truth_.truth.ground[i];
    if (std::abs(above) <= kGroundHit_m) ground_hit[i] = 1;
    if (p.z_m <= ground_up_to_m_[i])
    {
      lowest_m_[i] = std::fmin(lowest_m_[i], p.z_m);
      highest_m_[i] = std::fmax(highest_m_[i], p.z_m);
    }
    if (truth_.vertical[i] && above > obstacle_from_m() &&
        above <= truth_.standing_m(i) + kTopTolerance_m)
      high_hit_[i] = 1;
  }
}

bool Observed::shows_obstacle(std::size_t at) const
{
  if (!truth_.blocked(at)) return false;
  if (truth_.vertical[at]) return high_hit_[at];
  if (std::isnan(lowest_m_[at])) return false;
  float low = lowest_m_[at], high = highest_m_[at];
  for_each_around(
      truth_.truth.window, at, kAround_cells,
      [&](std::size_t i)
      {
        low = std::fmin(low, lowest_m_[i]);
        high = std::fmax(high, highest_m_[i]);
      });
  return high - low > obstacle_from_m();
}

float Observed::obstacle_from_m() const
{
  return static_cast<float>(parameters_.step_threshold_m) + kDoubt_m;
}

}  // namespace talus::baselines
