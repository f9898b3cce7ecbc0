#include <opencv2/core.hpp>
#include <talus/baselines/paper_map.h>
#include <talus/baselines/fills.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::baselines
{
namespace
{
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

}  // namespace

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

}  // namespace talus::baselines
