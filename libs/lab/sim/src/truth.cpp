#include <talus/sim/truth.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace talus::sim
{
namespace
{
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr double kMaxBytes = 2e9;
constexpr int kLayers = 6;
constexpr double kTouch_m = 1e-3;  //!< less than this above the ground does not stand on it
constexpr double kAir_m = 0.01;
const double kFaceSlope = std::tan(radians(85));  //!< steeper ground is a face, not a slope
constexpr int kAlong = 20;  //!< points on each side of a cell at which a stretch may begin or end
constexpr double kLong_m = 1;  //!< steep ground of this length blocks, however little it rises
constexpr int kHalves = 7;  //!< of the interval between two samples, to find a face of a few mm

void check_size(double cells_x, double cells_y, double resolution_m)
{
  if (!(resolution_m > 0) || !std::isfinite(resolution_m))
    throw std::invalid_argument("the resolution of the truth must be positive");
  const double bytes = cells_x * cells_y * kLayers * sizeof(float);
  if (bytes <= kMaxBytes) return;
  std::ostringstream msg;
  msg.precision(12);
  msg << "the truth of " << cells_x * resolution_m << " x " << cells_y * resolution_m << " m at "
      << resolution_m << " m would be " << cells_x << " x " << cells_y << " cells, "
      << std::ceil(bytes / 1e8) / 10 << " GB; the limit is " << kMaxBytes / 1e9
      << " GB: take coarser cells or a smaller world";
  throw std::runtime_error(msg.str());
}

/** Judges one cell after another, with its buffers. */
class CellJudge
{
 public:
  CellJudge(const Scene& scene, const TruthOptions& options)
      : scene_(scene),
        options_(options),
        max_gradient_(std::tan(options.max_slope_rad)),
        n_(options.samples + 2)
  {
    heights_.resize(static_cast<std::size_t>(n_) * n_);
  }

  void judge(double x_m, double y_m, double resolution_m, std::size_t index, Truth& out)
  {
    const double cx = x_m + 0.5 * resolution_m, cy = y_m + 0.5 * resolution_m;
    if (!scene_.ground().defined(cx, cy)) return;
    out.ground[index] = static_cast<float>(floor_m(cx, cy));
    sample_ground(x_m, y_m, resolution_m);
    int standing = 0;
    solid_samples_ = 0;
    for (int j = 1; j + 1 < n_; ++j)
      for (int i = 1; i + 1 < n_; ++i)
        standing += column_blocks(
            x_m + offset(i, resolution_m), y_m + offset(j, resolution_m), height(i, j), index, out);
    const bool ground = ground_blocks(resolution_m);
    const int covered = std::max(standing, ground ? steep_samples(resolution_m) : 0);
    out.label[index] = standing > 0 || ground ? 0.0f : 1.0f;
    const auto samples = static_cast<float>((n_ - 2) * (n_ - 2));
    out.covered[index] = static_cast<float>(covered) / samples;
    out.solid[index] = static_cast<float>(solid_samples_) / samples;
  }

 private:
  double floor_m(double x_m, double y_m) const
  {
    if (!options_.level_m) return scene_.ground().height_m(x_m, y_m);
    return scene_.floor_m(x_m, y_m, *options_.level_m + options_.max_step_m);
  }

  /** Samples 1 .. n-2 lie evenly inside the cell, 0 and n-1 just beyond its borders. */
  double offset(int i, double resolution_m) const
  {
    if (i == 0) return -kTouch_m;
    if (i == n_ - 1) return resolution_m + kTouch_m;
    return resolution_m * (i - 0.5) / (n_ - 2);
  }

  double height(int i, int j) const { return heights_[static_cast<std::size_t>(j) * n_ + i]; }

  void sample_ground(double x_m, double y_m, double resolution_m)
  {
    corner_x_m_ = x_m;
    corner_y_m_ = y_m;
    for (int j = 0; j < n_; ++j)
      for (int i = 0; i < n_; ++i)
        heights_[static_cast<std::size_t>(j) * n_ + i] =
            floor_m(x_m + offset(i, resolution_m), y_m + offset(j, resolution_m));
  }

  /** What the ground does from one sample of the cell to the next. */
  struct Rise
  {
    double rise_m, run_m;
    bool face;  //!< steeper than kFaceSlope somewhere in between
  };

  /** From sample i to the next along an axis (0: x), at index j of the other. Samples are too far
   * apart to tell a low face from a slope: halves of the interval show where it is steepest. */
  Rise rise_after(int i, int j, int axis, double resolution_m) const
  {
    const auto sample_m = [&](int k) { return axis == 0 ? height(k, j) : height(j, k); };
    const auto height_m = [&](double along_m)
    {
      const double across_m = offset(j, resolution_m);
      return axis == 0 ? floor_m(corner_x_m_ + along_m, corner_y_m_ + across_m)
                       : floor_m(corner_x_m_ + across_m, corner_y_m_ + along_m);
    };
    double from_m = offset(i, resolution_m), to_m = offset(i + 1, resolution_m);
    double low_m = sample_m(i), high_m = sample_m(i + 1);
    Rise whole{high_m - low_m, to_m - from_m, false};
    if (std::abs(whole.rise_m) <= max_gradient_ * whole.run_m) return whole;
    for (int half = 0; half < kHalves; ++half)
    {
      const double middle_m = 0.5 * (from_m + to_m), z_m = height_m(middle_m);
      const bool first = std::abs(z_m - low_m) >= std::abs(high_m - z_m);
      (first ? to_m : from_m) = middle_m;
      (first ? high_m : low_m) = z_m;
    }
    whole.face = std::abs(high_m - low_m) > kFaceSlope * (to_m - from_m);
    return whole;
  }

  bool ground_blocks(double resolution_m) const
  {
    double slope_sum[2] = {0, 0};
    int slopes[2] = {0, 0};
    for (int j = 0; j < n_; ++j)
    {
      double face_m[2] = {0, 0};  // a face may lean, so that several samples share its height
      for (int i = 0; i + 1 < n_; ++i)
      {
        for (int axis = 0; axis < 2; ++axis)
        {
          const Rise rise = rise_after(i, j, axis, resolution_m);
          face_m[axis] = rise.face ? face_m[axis] + rise.rise_m : 0;
          if (std::abs(face_m[axis]) > options_.max_step_m) return true;
          if (rise.face) continue;
          slope_sum[axis] += rise.rise_m / rise.run_m;
          ++slopes[axis];
        }
      }
    }
    const double gx = slopes[0] ? slope_sum[0] / slopes[0] : 0;
    const double gy = slopes[1] ? slope_sum[1] / slopes[1] : 0;
    const double gradient = std::hypot(gx, gy);
    return gradient > max_gradient_ && rises_by_a_step(gx / gradient, gy / gradient, resolution_m);
  }

  /** Whether a stretch through the centre of the cell, along a direction, is steeper than the
   * ground may be and rises by more than a step, or for more than kLong_m: what a robot steps over
   * it also climbs when it leans. */
  bool rises_by_a_step(double along_x, double along_y, double resolution_m) const
  {
    const double enough_m = std::min(options_.max_step_m, kLong_m * max_gradient_);
    const double spacing_m = enough_m / max_gradient_ / kAlong;
    const double cx = corner_x_m_ + 0.5 * resolution_m, cy = corner_y_m_ + 0.5 * resolution_m;
    double profile_m[2 * kAlong + 1];
    for (int k = 0; k <= 2 * kAlong; ++k)
      profile_m[k] =
          floor_m(cx + (k - kAlong) * spacing_m * along_x, cy + (k - kAlong) * spacing_m * along_y);
    for (int from = 0; from <= kAlong; ++from)
      for (int to = kAlong; to <= 2 * kAlong; ++to)
      {
        const double rise_m = profile_m[to] - profile_m[from];
        if (rise_m > enough_m && rise_m > max_gradient_ * (to - from) * spacing_m) return true;
      }
    return false;
  }

  /** Of the samples inside the cell, those beside which the ground is steeper than it may be. */
  int steep_samples(double resolution_m) const
  {
    int steep = 0;
    for (int j = 1; j + 1 < n_; ++j)
      for (int i = 1; i + 1 < n_; ++i)
      {
        const double run_x = offset(i + 1, resolution_m) - offset(i - 1, resolution_m);
        const double run_y = offset(j + 1, resolution_m) - offset(j - 1, resolution_m);
        const double gx = (height(i + 1, j) - height(i - 1, j)) / run_x;
        const double gy = (height(i, j + 1) - height(i, j - 1)) / run_y;
        steep += std::hypot(gx, gy) > max_gradient_;
      }
    return steep;
  }

  bool column_blocks(double x_m, double y_m, double ground_m, std::size_t index, Truth& out)
  {
    scene_.column(x_m, y_m, spans_);
    double level = ground_m;
    float& underside = out.underside[index];
    double lowest_air = std::numeric_limits<double>::infinity();
    bool solid = true;
    for (const Span& s : spans_)
    {
      if (s.exit_m <= ground_m) continue;
      if (s.enter_m > level + kAir_m) lowest_air = std::min(lowest_air, s.enter_m);
      if (s.enter_m > level + options_.clearance_m) break;
      solid &= s.enter_m <= level + kAir_m && !s.foliage;
      level = std::max(level, s.exit_m);
    }
    if (std::isfinite(lowest_air))
      underside = std::isnan(underside) ? static_cast<float>(lowest_air)
                                        : std::min(underside, static_cast<float>(lowest_air));
    if (level <= ground_m + kTouch_m) return false;
    solid_samples_ += solid;
    float& top = out.obstacle_top[index];
    top = std::isnan(top) ? static_cast<float>(level) : std::max(top, static_cast<float>(level));
    return level - ground_m > options_.min_obstacle_m;
  }

  const Scene& scene_;
  const TruthOptions& options_;
  double max_gradient_;  //!< of the ground
  int solid_samples_ = 0;
  int n_;  //!< samples along a side, those beyond the borders included
  double corner_x_m_ = 0, corner_y_m_ = 0;  //!< of the cell
  std::vector<double> heights_;
  std::vector<Span> spans_;
};

}  // namespace

TruthWindow window_around(const Bounds& area, double margin_m, double resolution_m)
{
  const double size_x = area.max_m.x - area.min_m.x + 2 * margin_m;
  const double size_y = area.max_m.y - area.min_m.y + 2 * margin_m;
  check_size(size_x / resolution_m + 1, size_y / resolution_m + 1, resolution_m);
  const auto cell = [&](double v) { return std::floor(v / resolution_m + 1e-9); };
  TruthWindow w;
  w.resolution_m = resolution_m;
  const double first_x = cell(area.min_m.x - margin_m), first_y = cell(area.min_m.y - margin_m);
  w.min_x_m = first_x * resolution_m;
  w.min_y_m = first_y * resolution_m;
  w.cells_x = static_cast<int>(cell(area.max_m.x + margin_m) - first_x) + 1;
  w.cells_y = static_cast<int>(cell(area.max_m.y + margin_m) - first_y) + 1;
  return w;
}

Truth truth(const World& world, const TruthWindow& w, double time_s, const TruthOptions& options)
{
  check_size(w.cells_x, w.cells_y, w.resolution_m);
  if (w.cells_x < 0 || w.cells_y < 0 || options.samples < 1)
    throw std::invalid_argument("the truth needs cells, and samples in them");
  if (!(options.max_step_m > 0) || !(options.max_slope_rad > 0 && options.max_slope_rad < kPi / 2))
    throw std::invalid_argument(
        "the limits of step and slope of the truth must be positive, that of the slope below a "
        "right angle");
  const std::size_t cells = static_cast<std::size_t>(w.cells_x) * w.cells_y;
  Truth out;
  out.window = w;
  for (auto* layer :
       {&out.ground, &out.obstacle_top, &out.underside, &out.label, &out.covered, &out.solid})
    layer->assign(cells, kUnknown);
  const Scene scene(world, time_s, options.movers);
  CellJudge judge(scene, options);
  for (int iy = 0; iy < w.cells_y; ++iy)
    for (int ix = 0; ix < w.cells_x; ++ix)
      judge.judge(
          w.min_x_m + ix * w.resolution_m, w.min_y_m + iy * w.resolution_m, w.resolution_m,
          static_cast<std::size_t>(iy) * w.cells_x + ix, out);
  return out;
}

}  // namespace talus::sim
