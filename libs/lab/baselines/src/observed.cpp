#include <talus/baselines/window_truth.h>

#include <algorithm>
#include <cmath>

#include "nan.h"

namespace talus::baselines
{
namespace
{
constexpr int kAround_cells = 3;
constexpr float kGroundHit_m = 0.05f;
constexpr float kTopTolerance_m = 0.06f;

/** Calls visit(index) for a cell and those up to so many cells from it. */
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

Observed::Observed(const TruthMap& truth, const Parameters& parameters)
    : ground_hit(truth.size(), 0),
      high_hit_(truth.size(), 0),
      lowest_m_(truth.size(), kNan),
      highest_m_(truth.size(), kNan),
      ground_up_to_m_(truth.size(), kNan),
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
  const sim::TruthWindow& area = truth_.truth.window;
  const double res = area.resolution_m;
  for (int iy = 0; iy < area.cells_y; ++iy)
    for (int ix = 0; ix < area.cells_x; ++ix)
    {
      const double x = area.min_x_m + (ix + 0.5) * res, y = area.min_y_m + (iy + 0.5) * res;
      if (cell_index(window, x, y) >= 0) continue;
      const auto i = static_cast<std::size_t>(iy * area.cells_x + ix);
      ground_hit[i] = high_hit_[i] = 0;
      lowest_m_[i] = highest_m_[i] = kNan;
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
