#include <talus/baselines/window_truth.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::baselines
{
namespace
{
constexpr float kOnMover_m = 0.1f;  //!< hits higher than this are on the mover
constexpr float kSeenThrough_m = 0.1f;
constexpr int kFreedFrames = 5;

/** Half side of the square that holds a mover in any heading [m]. */
double reach_m(const sim::Mover& mover)
{
  double reach = 0;
  for (const sim::Shape& s : mover.shapes)
  {
    const sim::Bounds b = sim::bounds(s);
    reach = std::max(
        {reach, std::hypot(b.max_m.x, b.max_m.y), std::hypot(b.min_m.x, b.min_m.y),
         std::hypot(b.max_m.x, b.min_m.y), std::hypot(b.min_m.x, b.max_m.y)});
  }
  return reach;
}

/** Where what is in a cell begins: above the air below it; on the ground nothing is below it. */
float bottom_of(const sim::Truth& now, std::size_t i)
{
  const bool lifted = now.underside[i] < now.obstacle_top[i];
  return lifted ? now.underside[i] : -std::numeric_limits<float>::infinity();
}

bool judged(const TruthMap& truth, std::size_t i) { return truth.surely_free(i) && truth.clear(i); }

}  // namespace

MoverTruth::MoverTruth(const TruthMap& truth, const sim::World& world, const Parameters& p)
    : blocked_now(truth.size(), 0),
      near_now(truth.size(), 0),
      touched(truth.size(), 0),
      underside_m(truth.size(), NAN),
      hit_top_m(truth.size(), NAN),
      lowest_ray_m(truth.size(), NAN),
      went_through(truth.size(), 0),
      seen_through_frame(truth.size(), -1),
      truth_(truth),
      world_(world),
      parameters_(p)
{
}

void MoverTruth::mark_movers(double time_s)
{
  std::fill(blocked_now.begin(), blocked_now.end(), 0);
  std::fill(near_now.begin(), near_now.end(), 0);
  const double res = truth_.truth.window.resolution_m;
  for (const sim::Mover& mover : world_.movers)
  {
    const Pose pose = mover.pose(time_s);
    const double r = reach_m(mover) + res;
    const sim::Bounds area{{pose.x() - r, pose.y() - r, 0}, {pose.x() + r, pose.y() + r, 0}};
    const sim::TruthWindow w = sim::window_around(area, res, res);
    const sim::Truth now =
        sim::truth(world_, w, time_s, TruthMap::truth_options(parameters_, true));
    const auto first_x = static_cast<std::int64_t>(std::llround(w.min_x_m / res));
    const auto first_y = static_cast<std::int64_t>(std::llround(w.min_y_m / res));
    for (int i = 0; i < w.cells_x * w.cells_y; ++i)
    {
      const std::int64_t x = first_x + i % w.cells_x, y = first_y + i / w.cells_x;
      const int at = truth_.index(x, y);
      if (at < 0 || now.label[i] != 0.0f) continue;
      if (truth_.blocked(at)) continue;
      blocked_now[at] = 1;
      const float bottom_m = bottom_of(now, static_cast<std::size_t>(i));
      for (int d = 0; d < 9; ++d)
      {
        const int near = truth_.index(x + d % 3 - 1, y + d / 3 - 1);
        if (near < 0) continue;
        near_now[near] = 1;
        float& underside = underside_m[near];
        underside = std::fmin(underside, bottom_m);
      }
    }
  }
}

void MoverTruth::enter_rays(const ScanFrame& scan)
{
  std::fill(lowest_ray_m.begin(), lowest_ray_m.end(), NAN);
  std::fill(went_through.begin(), went_through.end(), 0);
  Frame view = scan.view();
  view.T_map_sensor = scan.T_true;
  const Pose& from = scan.T_true;
  const double res = parameters_.resolution_m, reach = 0.5 * parameters_.window_m * std::sqrt(2.0);
  const auto cell = [&](double x, double y)
  {
    return truth_.index(
        static_cast<std::int64_t>(std::floor(x / res)),
        static_cast<std::int64_t>(std::floor(y / res)));
  };
  for (const MapPoint& p : accepted_points(view, parameters_))
  {
    const double dx = p.x_m - from.x(), dy = p.y_m - from.y(), length = std::hypot(dx, dy);
    const int steps = static_cast<int>(std::min(length, reach) / (0.5 * res));
    for (int s = 0; s < steps; ++s)
    {
      const double t = s * 0.5 * res / length;
      const int at = cell(from.x() + t * dx, from.y() + t * dy);
      if (at < 0) continue;
      enter_ray(
          static_cast<std::size_t>(at), static_cast<float>(from.z() + t * (p.z_m - from.z())));
    }
    const int end = cell(p.x_m, p.y_m);
    if (end < 0) continue;
    const auto i = static_cast<std::size_t>(end);
    if (near_now[i] && p.z_m - truth_.truth.ground[i] > kOnMover_m)
      hit_top_m[i] = std::fmax(hit_top_m[i], p.z_m);
  }
}

void MoverTruth::enter_ray(std::size_t cell, float height_m)
{
  if (!touched[cell]) return;
  lowest_ray_m[cell] = std::fmin(lowest_ray_m[cell], height_m);
  const float top_m = hit_top_m[cell], underside = underside_m[cell];
  const float below_m = std::fmax(top_m - kSeenThrough_m, 0.5f * (underside + top_m));
  went_through[cell] |= height_m >= underside && height_m < below_m;
}

bool MoverTruth::sees_through(std::size_t cell) const
{
  return went_through[cell] &&
         lowest_ray_m[cell] < truth_.truth.ground[cell] + parameters_.step_threshold_m;
}

void MoverTruth::forget_outside(const Window& window)
{
  for (std::size_t i = 0; i < touched.size(); ++i)
  {
    const auto [x_m, y_m] = truth_.middle(i);
    if (!touched[i] || cell_index(window, x_m, y_m) >= 0) continue;
    touched[i] = 0;
    underside_m[i] = NAN;
    hit_top_m[i] = NAN;
    seen_through_frame[i] = -1;
  }
}

void MoverTruth::advance(const ScanFrame& scan)
{
  ++frame;
  mark_movers(scan.time_s);
  enter_rays(scan);
  for (std::size_t i = 0; i < touched.size(); ++i)
  {
    if (near_now[i])
    {
      touched[i] = 1;
      seen_through_frame[i] = -1;
    }
    else if (seen_through_frame[i] < 0 && touched[i] && sees_through(i))
      seen_through_frame[i] = frame;
  }
  forget_outside(window_around(parameters_, pose_of_base(scan.T_true, scan.T_base_sensor)));
}

bool MoverWatch::has_work(const MoverTruth& movers, const TruthMap& truth) const
{
  for (std::size_t i = 0; i < freed_.size(); ++i)
    if (movers.seen_through_frame[i] >= 0 && !(freed_[i] && counted_[i]) && judged(truth, i))
      return true;
  return false;
}

void MoverWatch::look(
    const MoverTruth& movers, const TruthMap& truth, const Surfaces& map, Score& score)
{
  const int n = map.window.cells;
  for (int k = 0; k < n * n; ++k)
  {
    const int at = truth.index(map.window.min_cell_x + k % n, map.window.min_cell_y + k / n);
    if (at < 0) continue;
    const auto i = static_cast<std::size_t>(at);
    const int since = movers.seen_through_frame[i];
    if (since < 0) freed_[i] = counted_[i] = 0;
    if (since < 0 || !judged(truth, i)) continue;
    const int frames = movers.frame - since;
    if (!freed_[i] && map.passable(k))
    {
      freed_[i] = 1;
      score.residue_frames.add(static_cast<float>(frames));
    }
    if (frames < kFreedFrames || counted_[i]) continue;
    counted_[i] = 1;
    score.mover_freed.add(freed_[i]);
  }
}

}  // namespace talus::baselines
