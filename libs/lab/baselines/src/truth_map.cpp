#include <talus/baselines/truth_map.h>
#include <talus/baselines/window_cells.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace talus::baselines
{
namespace
{
constexpr float kJump_m = 0.05f;
constexpr int kNearStep_cells = 3;
constexpr double kSlope_rad = 0.035;
constexpr double kRough_m = 0.003;
constexpr float kDitchDepth_m = 0.3f;
constexpr double kDitchWidth_m = 1.5;
constexpr double kPlatform_m = 1.0;
constexpr double kOnPlatform_m = 0.5;  //!< what stands on a platform is narrower
constexpr double kCorner_m = 0.5;  //!< a disc as wide as a platform leaves its corners free
constexpr int kPost_cells = 5;
constexpr float kPostHeight_m = 0.3f;

cv::Mat as_image(std::vector<std::uint8_t>& v, const sim::TruthWindow& w)
{
  return cv::Mat(w.cells_y, w.cells_x, CV_8U, v.data());
}

/** Of the cell at an index of the TruthMap. */
template <class T>
T value(const cv::Mat& whole_image, std::size_t i)
{
  return whole_image.ptr<T>()[i];
}

cv::Mat disc(double diameter_m, const sim::TruthWindow& w)
{
  const int side = static_cast<int>(diameter_m / w.resolution_m) | 1;
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
}

/** Chessboard distance of each cell to the nearest one that is zero in `mask`. */
std::vector<std::uint8_t> distance_to_zero(
    std::vector<std::uint8_t> mask, const sim::TruthWindow& w)
{
  cv::Mat distance, small;
  cv::distanceTransform(as_image(mask, w), distance, cv::DIST_C, 3);
  distance.convertTo(small, CV_8U);
  return {small.begin<std::uint8_t>(), small.end<std::uint8_t>()};
}

/** Slope and RMS distance from a plane of heights on a square, row by row. */
struct PlaneFit
{
  double slope_rad = 0, rms_m = 0;
};

PlaneFit fit_plane(
    const std::vector<float>& ground_m, int cells_x, int ix, int iy, int r, double res)
{
  double z = 0, zz = 0, xz = 0, yz = 0, xx = 0, n = 0;
  const float own = ground_m[iy * cells_x + ix];
  for (int dy = -r; dy <= r; ++dy)
    for (int dx = -r; dx <= r; ++dx)
    {
      const double h = static_cast<double>(ground_m[(iy + dy) * cells_x + ix + dx]) - own;
      n += 1, z += h, zz += h * h, xz += dx * h, yz += dy * h, xx += dx * dx;
    }
  const double gx = xz / xx, gy = yz / xx;  // on a full square x, y and 1 are orthogonal
  const double residual = std::max(zz - z * z / n - gx * xz - gy * yz, 0.0);
  return {std::atan(std::hypot(gx, gy) / res), std::sqrt(residual / n)};
}

}  // namespace

sim::TruthOptions TruthMap::truth_options(const Parameters& p, bool movers)
{
  sim::TruthOptions o;
  o.movers = movers;
  o.clearance_m = p.clearance_m;
  o.min_obstacle_m = p.step_threshold_m;
  o.max_slope_rad = p.slope_threshold_rad;
  o.max_step_m = p.step_threshold_m;
  return o;
}

TruthMap::TruthMap(sim::Truth t, const Parameters& parameters)
    : truth(std::move(t)),
      first_cell_x_(std::llround(truth.window.min_x_m / truth.window.resolution_m)),
      first_cell_y_(std::llround(truth.window.min_y_m / truth.window.resolution_m))
{
  classify_cells(parameters);
  classify_terrain();
  find_islets(parameters);
  find_platforms(parameters);
  measure_distances();
  find_ditches();
  find_posts();
}

float TruthMap::standing_m(std::size_t i) const
{
  const float top = truth.obstacle_top[i];
  return top == top ? top - truth.ground[i] : 0.0f;
}

float TruthMap::height_error_m(std::size_t i, float z_m) const
{
  const float from_ground = std::abs(z_m - truth.ground[i]);
  if (!free(i) || standing_m(i) == 0.0f) return from_ground;
  return std::min(from_ground, std::abs(z_m - truth.obstacle_top[i]));
}

void TruthMap::classify_cells(const Parameters& p)
{
  const auto step = static_cast<float>(p.step_threshold_m);
  const auto clearance = static_cast<float>(p.clearance_m);
  for (auto* layer : {&hangs, &doubtful, &vertical}) layer->assign(size(), 0);
  for (std::size_t i = 0; i < size(); ++i)
  {
    const float stands = standing_m(i);
    const float air = truth.underside[i] - truth.ground[i];
    hangs[i] = free(i) && air > clearance;
    doubtful[i] = std::abs(stands - step) <= kDoubt_m || (hangs[i] && air <= clearance + kDoubt_m);
    vertical[i] = blocked(i) && stands > step;
  }
}

void TruthMap::classify_terrain()
{
  const sim::TruthWindow& w = truth.window;
  std::vector<std::uint8_t> calm(size(), 1);  // 0 at jumps
  const auto surface = [&](int i) { return surface_m(i); };
  for (int i = 0; i < static_cast<int>(size()); ++i)
    for (int next : {(i + 1) % w.cells_x ? i + 1 : i, i + w.cells_x})
      if (next < static_cast<int>(size()) && std::abs(surface(i) - surface(next)) > kJump_m)
        calm[i] = calm[next] = 0;
  const auto to_jump = distance_to_zero(calm, w);
  terrain.assign(size(), Terrain::Flat);
  constexpr int r = 3;
  for (int iy = r; iy + r < w.cells_y; ++iy)
    for (int ix = r; ix + r < w.cells_x; ++ix)
    {
      const auto i = static_cast<std::size_t>(iy * w.cells_x + ix);
      const PlaneFit plane = fit_plane(truth.ground, w.cells_x, ix, iy, r, w.resolution_m);
      terrain[i] = to_jump[i] <= kNearStep_cells  ? Terrain::NearStep
                   : plane.rms_m > kRough_m       ? Terrain::Rough
                   : plane.slope_rad > kSlope_rad ? Terrain::Slope
                                                  : Terrain::Flat;
    }
}

/** Of the cells that a solid top covers whole, those that lean less than ground may: towards a
 * neighbour along each axis, so that edges count, or `all_around` towards every other top. */
std::vector<std::uint8_t> TruthMap::level_tops(const Parameters& p, bool all_around) const
{
  const sim::TruthWindow& w = truth.window;
  const auto rise_m = static_cast<float>(std::tan(p.slope_threshold_rad) * w.resolution_m);
  const auto top = [&](std::size_t i) { return truth.solid[i] == 1.0f; };
  std::vector<std::uint8_t> level(size(), 0);
  for (int iy = 1; iy + 1 < w.cells_y; ++iy)
    for (int ix = 1; ix + 1 < w.cells_x; ++ix)
    {
      const auto i = static_cast<std::size_t>(iy * w.cells_x + ix);
      const auto lean = [&](std::size_t next)
      { return top(next) && std::abs(surface_m(next) - surface_m(i)) > rise_m; };
      const auto same = [&](std::size_t next) { return top(next) && !lean(next); };
      const auto row = static_cast<std::size_t>(w.cells_x);
      const bool steep = lean(i - 1) || lean(i + 1) || lean(i - row) || lean(i + row);
      const bool goes_on = (same(i - 1) || same(i + 1)) && (same(i - row) || same(i + row));
      level[i] = top(i) && (all_around ? !steep : goes_on);
    }
  return level;
}

void TruthMap::find_islets(const Parameters& p)
{
  const sim::TruthWindow& w = truth.window;
  std::vector<std::uint8_t> open(size());
  std::vector<float> lowest_m(size());
  for (std::size_t i = 0; i < size(); ++i)
    open[i] = free(i), lowest_m[i] = known(i) ? truth.ground[i] : FLT_MAX;
  cv::Mat labels, wide;
  const int n = cv::connectedComponents(as_image(open, w), labels, 4);
  cv::morphologyEx(as_image(open, w), wide, cv::MORPH_OPEN, disc(kPlatform_m, w));
  const int around = 2 * static_cast<int>(kPlatform_m / w.resolution_m) + 1;
  const cv::Mat lowest(w.cells_y, w.cells_x, CV_32F, lowest_m.data());
  cv::erode(lowest, lowest, cv::Mat::ones(around, around, CV_8U));
  std::vector<std::uint8_t> narrow(static_cast<std::size_t>(n), 1);
  const auto part = [&](std::size_t i) { return static_cast<std::size_t>(value<int>(labels, i)); };
  for (std::size_t i = 0; i < size(); ++i)
    if (value<std::uint8_t>(wide, i)) narrow[part(i)] = 0;
  for (std::size_t i = 0; i < size(); ++i)
    if (open[i] && narrow[part(i)] &&
        truth.ground[i] - lowest_m[i] > static_cast<float>(p.step_threshold_m))
      doubtful[i] = 1;
}

void TruthMap::find_platforms(const Parameters& p)
{
  const sim::TruthWindow& w = truth.window;
  std::vector<std::uint8_t> level = level_tops(p, true), whole = level;
  const cv::Mat tops = as_image(whole, w);
  cv::morphologyEx(tops, tops, cv::MORPH_CLOSE, disc(kOnPlatform_m, w));
  std::vector<std::uint8_t> wide = whole;
  const cv::Mat image = as_image(wide, w);
  cv::morphologyEx(image, image, cv::MORPH_OPEN, disc(kPlatform_m, w));
  cv::dilate(image, image, disc(kCorner_m, w));
  const auto to_edge = distance_to_zero(whole, w);
  const auto climbed =
      climbed_tops(level_tops(p, false), static_cast<float>(p.step_threshold_m) + kDoubt_m);
  platform.resize(size());
  climbable.resize(size());
  for (std::size_t i = 0; i < size(); ++i)
  {
    platform[i] = level[i] && wide[i] && to_edge[i] > 1;
    climbable[i] = platform[i] && climbed[i];
  }
}

/** Of the cells of `level`, those that a path from free ground reaches without a higher step. */
std::vector<std::uint8_t> TruthMap::climbed_tops(
    const std::vector<std::uint8_t>& level, float step_m) const
{
  std::vector<std::uint8_t> climbed(size(), 0);
  std::vector<int> todo;
  for (int i = 0; i < static_cast<int>(size()); ++i)
    if (free(i)) todo.push_back(i);
  spread(
      todo, climbed, truth.window.cells_x,
      [&](std::size_t from, std::size_t to)
      { return level[to] && std::abs(surface_m(from) - surface_m(to)) <= step_m; });
  return climbed;
}

void TruthMap::measure_distances()
{
  std::vector<std::uint8_t> clear(size()), blocks(size());
  for (std::size_t i = 0; i < size(); ++i)
    blocks[i] = blocked(i), clear[i] = !blocked(i) && !doubtful[i];
  to_obstacle = distance_to_zero(clear, truth.window);
  depth = distance_to_zero(blocks, truth.window);
}

void TruthMap::find_ditches()
{
  const sim::TruthWindow& w = truth.window;
  std::vector<float> ground = truth.ground;
  for (float& h : ground)
    if (h != h) h = 0;
  const int side = static_cast<int>(kDitchWidth_m / w.resolution_m) | 1;
  cv::Mat depth_m;
  cv::morphologyEx(
      cv::Mat(w.cells_y, w.cells_x, CV_32F, ground.data()), depth_m, cv::MORPH_BLACKHAT,
      cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  ditch.assign(size(), 0);
  for (std::size_t i = 0; i < size(); ++i) ditch[i] = value<float>(depth_m, i) > kDitchDepth_m;
}

void TruthMap::find_posts()
{
  const sim::TruthWindow& w = truth.window;
  std::vector<std::uint8_t> blocks(size());
  for (std::size_t i = 0; i < size(); ++i) blocks[i] = blocked(i);
  cv::Mat labels, stats, centroids;
  const int n = cv::connectedComponentsWithStats(as_image(blocks, w), labels, stats, centroids, 8);
  std::vector<float> height(static_cast<std::size_t>(n), 0.0f);
  for (std::size_t i = 0; i < size(); ++i)
  {
    float& h = height[value<int>(labels, i)];
    h = std::max(h, standing_m(i));
  }
  std::vector<int> number(static_cast<std::size_t>(n), -1);
  for (int c = 1; c < n; ++c)
    if (stats.at<int>(c, cv::CC_STAT_WIDTH) <= kPost_cells &&
        stats.at<int>(c, cv::CC_STAT_HEIGHT) <= kPost_cells && height[c] > kPostHeight_m)
      number[c] = posts++;
  post.resize(size());
  for (std::size_t i = 0; i < size(); ++i) post[i] = number[value<int>(labels, i)];
}

}  // namespace talus::baselines
