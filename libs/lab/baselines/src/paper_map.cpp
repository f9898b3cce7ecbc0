#include <opencv2/core.hpp>
#include <talus/baselines/fills.h>
#include <talus/baselines/rivals.h>
#include <talus/baselines/window_cells.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace talus::baselines
{
namespace
{
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/** A cell of the paper's map. */
struct PaperCell
{
  /** Map frame, NaN: unknown. A filled cell has a ground only. */
  float elevation_m = std::numeric_limits<float>::quiet_NaN();
  float ground_m = std::numeric_limits<float>::quiet_NaN();
  /** One of both surfaces: the latest that was updated. NaN: never measured. */
  float variance_m2 = std::numeric_limits<float>::quiet_NaN();
  CellState state = CellState::Unknown;  //!< where the ground comes from

  bool stands() const { return elevation_m == elevation_m; }
  bool has_ground() const { return ground_m == ground_m; }
};
using PaperCells = RollingCells<PaperCell>;

constexpr int kDenseOneIn = 4;  //!< of the neighbourhood that is measured, or more: dense

/** The heights around a cell: G, and H with the ground where nothing stands. */
struct Around
{
  std::vector<cv::Vec3d> ground_m;  //!< x, y, z
  double lowest_ground_m = std::numeric_limits<double>::infinity();
  double elevations_m = 0;  //!< sum
  int measured = 0, side = 0;

  Around(const PaperCells& cells, int ix, int iy, int radius) : side(2 * radius + 1)
  {
    const Window& w = cells.window();
    ground_m.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    for (int y = std::max(iy - radius, 0); y <= std::min(iy + radius, w.cells - 1); ++y)
      for (int x = std::max(ix - radius, 0); x <= std::min(ix + radius, w.cells - 1); ++x)
      {
        const PaperCell& c = cells[y * w.cells + x];
        if (!c.has_ground()) continue;
        ground_m.emplace_back(x * w.resolution_m, y * w.resolution_m, c.ground_m);
        lowest_ground_m = std::min(lowest_ground_m, static_cast<double>(c.ground_m));
        elevations_m += c.stands() ? c.elevation_m : c.ground_m;
        measured += c.state == CellState::Measured;
      }
  }
  cv::Vec3d mean_ground_m() const
  {
    cv::Vec3d sum;
    for (const cv::Vec3d& g : ground_m) sum += g;
    return sum / static_cast<double>(ground_m.size());
  }
  double mean_elevation_m() const { return elevations_m / static_cast<double>(ground_m.size()); }
  bool is_dense() const { return kDenseOneIn * measured >= side * side; }
};

/** Angle between the normal of the plane of minimum distance and the z axis. Level with fewer than
 * three cells. */
double slope_rad(const Around& around, const cv::Vec3d& mean_m)
{
  if (around.ground_m.size() < 3) return 0;
  cv::Matx33d scatter = cv::Matx33d::zeros();
  for (const cv::Vec3d& g : around.ground_m)
  {
    const cv::Vec3d d = g - mean_m;
    scatter += d * d.t();
  }
  cv::Matx33d axes, rest;
  cv::Matx31d spreads;
  cv::SVD::compute(scatter, spreads, rest, axes);
  return std::acos(std::min(std::abs(axes(2, 2)), 1.0));  // the row of the minimum spread
}

/** Eq. 10 to 13. At most 1: eq. 11 and 12 are more in a hollow. */
float judge(const PaperCell& c, const Around& around, const Parameters& p)
{
  const cv::Vec3d mean_m = around.mean_ground_m();
  const double h_m = c.stands() ? c.elevation_m : c.ground_m;
  const double slope = 1 - slope_rad(around, mean_m) / p.slope_threshold_rad;
  const double step = 1 - (2 * h_m - around.lowest_ground_m - mean_m[2]) / (2 * p.step_threshold_m);
  const double roughness = 1 - (h_m - around.mean_elevation_m()) / p.roughness_threshold_m;
  if (slope <= 0 || step <= 0 || roughness <= 0) return 0;
  const double sum = p.weight_slope * slope + p.weight_step * step + p.weight_roughness * roughness;
  return static_cast<float>(std::min(sum, 1.0));
}

/** The measured ground nearest along the line; NaN: none. */
float first_ground_m(
    const PaperCells& cells, const CellLine& line, int direction, double farthest_m)
{
  for (int k = 1; k * line.step_m() <= farthest_m; ++k)
  {
    const int at = line(line.steps() + direction * k);
    if (at < 0) break;
    const PaperCell& c = cells[at];
    if (c.state == CellState::Measured) return c.ground_m;
  }
  return NAN;
}

/** Eq. 14. NaN where only one side has ground, or none. */
float sparsity(
    const PaperCells& cells, const CellLine& line, double distance_m, const Parameters& p)
{
  const float inner_m = first_ground_m(cells, line, -1, p.sparsity_search_m);
  const float outer_m = first_ground_m(cells, line, 1, p.sparsity_search_m);
  const double steps = std::abs(inner_m - outer_m) / p.step_threshold_m;
  const double share = steps >= 1 ? p.sparsity_distance_m / distance_m : 1.0;
  return std::isnan(steps) ? NAN : static_cast<float>(std::max(1 - steps * share, 0.0));
}

constexpr double kLambda = 1;  //!< weight of the prior, see eq. 8; the paper's value

/** What one direction of the line search found. */
struct Side
{
  int samples = 0;
  int gap_cells = 0;  //!< before the first sample: n1, n2 of eq. 9
  double height_m = 0;  //!< eq. 8
};

/** Eq. 8 with the lowest sample as the prior. `direction`: 1 away from the sensor, -1 towards it
 * (and on behind it). */
Side search(const PaperCells& cells, const CellLine& line, int direction, const Parameters& p)
{
  Side side;
  double weights = 0, weighted_m = 0, lowest_m = std::numeric_limits<double>::infinity();
  const auto farthest = static_cast<int>(p.fill_search_m / line.step_m());
  for (int k = 1; k <= farthest; ++k)
  {
    const int at = line(line.steps() + direction * k);
    if (at < 0) break;
    const PaperCell& c = cells[at];
    if (c.state != CellState::Measured) continue;
    if (side.samples++ == 0) side.gap_cells = k - 1;
    const double weight = sparse_kernel(k * line.step_m(), p.fill_kernel_m);
    weights += weight;
    weighted_m += weight * c.ground_m;
    lowest_m = std::min(lowest_m, static_cast<double>(c.ground_m));
  }
  side.height_m = (kLambda * lowest_m + weighted_m) / (kLambda + weights);
  return side;
}

/** Eq. 9. */
double combine(const Side& a, const Side& b)
{
  const Side& low = a.height_m <= b.height_m ? a : b;
  const Side& high = a.height_m <= b.height_m ? b : a;
  const int n_low = low.gap_cells, n_high = high.gap_cells;
  if (n_low + n_high == 0) return (low.height_m + high.height_m) / 2;  // 0 / 0: a gap of one cell
  return ((n_low + n_high) * low.height_m + n_high * high.height_m) / (n_low + 2 * n_high);
}

/** Traversability (eq. 10 to 13) and sparsity (eq. 14). */
void judge_as_printed(
    const PaperCells& cells, const Pose& T_map_sensor, const Parameters& p, Surfaces& s)
{
  const int n = cells.window().cells;
  const int radius =
      std::max(static_cast<int>(std::lround(p.feature_radius_m / p.resolution_m)), 1);
  s.sparsity.assign(cells.size(), NAN);
  for (int i = 0; i < n * n; ++i)
  {
    const auto at = static_cast<std::size_t>(i);
    const PaperCell& c = cells[at];
    if (!c.has_ground()) continue;
    const Around around(cells, i % n, i / n, radius);
    const CellLine line(cells.window(), T_map_sensor, i % n, i / n);
    const double distance_m = line.steps() * line.step_m();
    const bool suspicious = c.state == CellState::FilledOneSided && around.is_dense() &&
                            distance_m > 0 && distance_m < p.sparsity_range_m;
    if (suspicious) s.sparsity[at] = sparsity(cells, line, distance_m, p);
    s.traversability[at] = suspicious ? s.sparsity[at] : judge(c, around, p);
  }
}

/** What eq. 8 and 9 make of the measured ground along the line to the sensor. */
struct PaperFill
{
  float height_m;
  CellState state;  //!< Unknown: no sample on either side
};
PaperFill infer_as_printed(
    const PaperCells& cells, const Pose& T_map_sensor, int cell, const Parameters& p)
{
  const int n = cells.window().cells;
  const CellLine line(cells.window(), T_map_sensor, cell % n, cell / n);
  PaperFill fill{0, CellState::Unknown};
  if (line.steps() == 0) return fill;
  const Side inner = search(cells, line, -1, p), outer = search(cells, line, 1, p);
  if (inner.samples > 0 && outer.samples > 0)
    fill = {static_cast<float>(combine(inner, outer)), CellState::FilledTwoSided};
  else if (inner.samples > 0 || outer.samples > 0)
    fill = {
        static_cast<float>(inner.samples > 0 ? inner.height_m : outer.height_m),
        CellState::FilledOneSided};
  return fill;
}

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

/** The method of Xie et al., "Real-time elevation mapping with Bayesian ground filling and
 * traversability analysis for UGV navigation", section III as it is printed: plain code on one
 * thread, points in the order of the frame, to see what talus gained where. Where the text is open:
 * - a fill has no variance; the first point in its cell lends it its own. What is hit higher than
 * its gate stands on it, even where the fill was too low (Fig. 3, middle);
 * - the gap of Fig. 3, right, is looked for among the frame's points and the stored elevation;
 * - the line search goes on behind the sensor; the cell under the sensor lies on no line;
 * - dense (eq. 14) is a quarter of the neighbourhood measured, near is sparsity_range_m;
 * - the variance has a floor, min_variance_m2, as in the other maps.
 * Parameters that the paper has no word for (object_size_m, cleanup_*, ...) do nothing here. */
class PaperMap : public Method
{
 public:
  explicit PaperMap(const Parameters& parameters) : parameters_(parameters) {}

  void update(const Frame& frame) override
  {
    T_map_sensor_ = frame.T_map_sensor;
    cells_.move_to(
        window_around(parameters_, pose_of_base(frame.T_map_sensor, frame.T_base_sensor)));
    const std::vector<Hit> hits = hits_of(frame);
    update_cells(hits);
    fill(frame.T_map_sensor, CellState::FilledOneSided);
    clean_up(frame.T_map_sensor, hits);
    fill(frame.T_map_sensor, CellState::Unknown);
  }

  Surfaces read() override
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

 private:
  /** A point with its cell and its variance (section III-A). */
  struct Hit
  {
    int cell;
    float z_m, variance_m2;
  };
  using CellHits = std::vector<Hit>::const_iterator;  //!< of one cell, in the order of the frame

  /** sin(theta / 2) of the angle between the z axes of two poses (eq. 2 to 4). */
  double pose_change_sine(const Frame& frame)
  {
    const auto& now = frame.T_map_sensor.m;
    const auto [last, is_first] = last_pose_.try_emplace(frame.sensor, frame.T_map_sensor);
    const auto& before = last->second.m;
    const double cosine = now[2] * before[2] + now[6] * before[6] + now[10] * before[10];
    last->second = frame.T_map_sensor;
    return is_first ? 0.0 : std::sin(std::acos(std::clamp(cosine, -1.0, 1.0)) / 2);
  }

  /** Eq. 1 to 4. Sorted by cell. */
  std::vector<Hit> hits_of(const Frame& frame)
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
  bool fuse(float& height_m, PaperCell& c, const Hit& hit, bool keeps_higher) const
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
  float lowest_hanging_m(const PaperCell& c, CellHits begin, CellHits end) const
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
  void update_cell(PaperCell& c, CellHits begin, CellHits end) const
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

  void update_cells(const std::vector<Hit>& hits)
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
  void clean_up(const Pose& T_map_sensor, const std::vector<Hit>& hits)
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
  void fill(const Pose& T_map_sensor, CellState state)
  {
    for (std::size_t i = 0; i < cells_.size(); ++i)
    {
      PaperCell& c = cells_[i];
      if (c.state != state) continue;
      const PaperFill fill =
          infer_as_printed(cells_, T_map_sensor, static_cast<int>(i), parameters_);
      if (fill.state == CellState::Unknown) continue;
      c.ground_m = fill.height_m;
      c.state = fill.state;
    }
  }

  Parameters parameters_;
  PaperCells cells_;
  Pose T_map_sensor_;
  std::map<std::uint32_t, Pose> last_pose_;  //!< by sensor
};
}  // namespace

std::unique_ptr<Method> make_paper(const Parameters& parameters, Backend)
{
  return std::make_unique<PaperMap>(parameters);
}

}  // namespace talus::baselines
