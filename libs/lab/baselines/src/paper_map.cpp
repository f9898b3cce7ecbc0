#include <talus/baselines/window_cells.h>
#include <talus/baselines/paper_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace talus::baselines
{
namespace
{
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/** One point a voxel, the first (section IV-A). */
void thin(std::vector<MapPoint>& points, double voxel_m)
{
  std::set<std::array<double, 3>> taken;
  const auto is_taken = [&](const MapPoint& p)
  {
    const std::array<double, 3> voxel{
        std::floor(p.x_m / voxel_m), std::floor(p.y_m / voxel_m), std::floor(p.z_m / voxel_m)};
    return !taken.insert(voxel).second;
  };
  std::vector<MapPoint> kept;
  kept.reserve(points.size());
  for (const MapPoint& p : points)
    if (!is_taken(p)) kept.push_back(p);
  points = std::move(kept);
}

}  // namespace

/** sin(theta / 2) of the angle between the z axes of two poses (eq. 2 to 4). */
double PaperMap::pose_change_sine(const Frame& frame)
{
  const auto& now = frame.T_map_sensor.m;
  const auto [last, is_first] = last_pose_.try_emplace(frame.sensor, frame.T_map_sensor);
  const auto& before = last->second.m;
  const double cosine = now[2] * before[2] + now[6] * before[6] + now[10] * before[10];
  last->second = frame.T_map_sensor;
  return is_first ? 0.0 : std::sin(std::acos(std::clamp(cosine, -1.0, 1.0)) / 2);
}

/** Eq. 1 to 4. Sorted by cell. */
std::vector<PaperMap::Hit> PaperMap::hits_of(const Frame& frame)
{
  std::vector<MapPoint> points = accepted_points(frame, parameters_);
  if (parameters_.voxel_m > 0) thin(points, parameters_.voxel_m);
  const double turn = parameters_.lambda_t * pose_change_sine(frame);
  std::vector<Hit> hits;
  hits.reserve(points.size());
  for (const MapPoint& p : points)
  {
    const int cell = cell_index(cells_.window(), p.x_m, p.y_m);
    if (cell < 0) continue;
    const double sensor_m = parameters_.c_beam_m + parameters_.a_beam * p.range_m;
    const double turn_m = turn * p.range_m;
    hits.push_back({cell, p.z_m, static_cast<float>(sensor_m * sensor_m + turn_m * turn_m)});
  }
  std::stable_sort(
      hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.cell < b.cell; });
  return hits;
}

/** Eq. 5 to 7 on one of the surfaces. Whether it took the point. */
bool PaperMap::fuse(float& height_m, PaperCell& c, const Hit& hit, bool keeps_higher) const
{
  if (std::isnan(c.variance_m2)) c.variance_m2 = hit.variance_m2;  // of a fill
  const float difference = hit.z_m - height_m;
  const float distance = std::abs(difference) / std::sqrt(c.variance_m2);
  if (distance <= parameters_.mahalanobis_gate)
  {
    const float sum = c.variance_m2 + hit.variance_m2;
    height_m = (hit.variance_m2 * height_m + c.variance_m2 * hit.z_m) / sum;
    c.variance_m2 = std::max(
        c.variance_m2 * hit.variance_m2 / sum, static_cast<float>(parameters_.min_variance_m2));
    return true;
  }
  if (!std::isnan(height_m) && (difference > 0) != keeps_higher) return false;
  height_m = hit.z_m;
  c.variance_m2 = hit.variance_m2;
  return true;
}

/** The lowest of a cell's heights with a gap below it that the robot fits through. */
float PaperMap::lowest_hanging_m(const PaperCell& c, CellHits begin, CellHits end) const
{
  std::vector<float> heights_m;
  heights_m.reserve(static_cast<std::size_t>(end - begin) + 1);
  for (auto hit = begin; hit != end; ++hit) heights_m.push_back(hit->z_m);
  if (c.stands()) heights_m.push_back(c.elevation_m);
  std::sort(heights_m.begin(), heights_m.end());
  float below_m = c.ground_m;
  for (const float z_m : heights_m)
  {
    if (z_m - below_m > parameters_.clearance_m) return z_m;
    below_m = z_m;
  }
  return kInfinity;
}

/** Fig. 3, from left to right. */
void PaperMap::update_cell(PaperCell& c, CellHits begin, CellHits end) const
{
  const auto lower = [](const Hit& a, const Hit& b) { return a.z_m < b.z_m; };
  const float lowest_m = std::min_element(begin, end, lower)->z_m;
  if (lowest_m - c.ground_m > parameters_.clearance_m)  // all of it hangs
  {
    c.elevation_m = c.ground_m;
    return;
  }
  bool new_ground = false;
  for (auto hit = begin; hit != end; ++hit) new_ground |= fuse(c.ground_m, c, *hit, false);
  if (new_ground) c.state = CellState::Measured;
  // Over a ground that this frame did not hit, an obstacle is as high as its highest point.
  const float hanging_m = new_ground ? lowest_hanging_m(c, begin, end) : kInfinity;
  if (c.elevation_m >= hanging_m) c.elevation_m = c.ground_m;
  for (auto hit = begin; hit != end; ++hit)
    if (hit->z_m < hanging_m) fuse(c.elevation_m, c, *hit, true);
}

void PaperMap::update_cells(const std::vector<Hit>& hits)
{
  for (auto begin = hits.begin(); begin != hits.end();)
  {
    const auto end = std::find_if(
        begin, hits.end(), [begin](const Hit& hit) { return hit.cell != begin->cell; });
    update_cell(cells_[begin->cell], begin, end);
    begin = end;
  }
}

/** Fig. 4: what was not hit and stands higher than the ray to the next hit behind it falls to its
 * ground. */
void PaperMap::clean_up(const Pose& T_map_sensor, const std::vector<Hit>& hits)
{
  std::vector<float> lowest_m(cells_.size(), kInfinity);
  for (const Hit& hit : hits)
  {
    float& z_m = lowest_m[hit.cell];
    z_m = std::min(z_m, hit.z_m);
  }
  const auto sensor_m = static_cast<float>(T_map_sensor.z());
  const int n = cells_.window().cells;
  for (int i = 0; i < n * n; ++i)
  {
    PaperCell& c = cells_[i];
    if (!c.stands() || lowest_m[i] < kInfinity) continue;
    const CellLine line(cells_.window(), T_map_sensor, i % n, i / n);
    if (line.steps() == 0) continue;
    int step = line.steps() + 1, at = line(step);
    while (at >= 0 && lowest_m[at] == kInfinity) at = line(++step);
    if (at < 0) continue;  // nothing was hit behind it
    const float share = static_cast<float>(line.steps()) / static_cast<float>(step);
    const float threshold_m = sensor_m + share * (lowest_m[at] - sensor_m);
    if (c.elevation_m > threshold_m) c.elevation_m = c.ground_m;
  }
}

/** Infers the ground of all cells that are in a state: unknown ones, or, once more, what was
 * filled from one side. What was filled from two sides is never touched again. */
void PaperMap::fill(const Pose& T_map_sensor, CellState state)
{
  for (std::size_t i = 0; i < cells_.size(); ++i)
  {
    PaperCell& c = cells_[i];
    if (c.state != state) continue;
    const PaperFill fill = infer_as_printed(cells_, T_map_sensor, static_cast<int>(i), parameters_);
    if (fill.state == CellState::Unknown) continue;
    c.ground_m = fill.height_m;
    c.state = fill.state;
  }
}

void PaperMap::update(const Frame& frame)
{
  T_map_sensor_ = frame.T_map_sensor;
  cells_.move_to(window_around(parameters_, pose_of_base(frame.T_map_sensor, frame.T_base_sensor)));
  const std::vector<Hit> hits = hits_of(frame);
  update_cells(hits);
  fill(frame.T_map_sensor, CellState::FilledOneSided);
  clean_up(frame.T_map_sensor, hits);
  fill(frame.T_map_sensor, CellState::Unknown);
}

Surfaces PaperMap::read()
{
  Surfaces s(cells_.window());
  for (std::size_t i = 0; i < cells_.size(); ++i)
  {
    const PaperCell& c = cells_[i];
    s.ground_m[i] = c.ground_m;
    s.elevation_m[i] = c.stands() ? c.elevation_m : c.ground_m;
    s.state[i] = static_cast<std::uint8_t>(c.state);
  }
  judge_as_printed(cells_, T_map_sensor_, parameters_, s);
  return s;
}

}  // namespace talus::baselines
